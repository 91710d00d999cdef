"""The certificate of several contacts rejects what is no equilibrium; where profiles pull."""

import contextlib
import math
from dataclasses import replace

import numpy as np
import pytest
from support.example_scenes import ALPHA, DELTA0, L, adhesive, plain, rippled, tips, wavy

from discretization import NotCertifiedError, minimise
from discretization.fitted.contact_lines import ContactLines
from discretization.fitted.contacts import Contacts, certify, errors
from discretization.fitted.rest_depths import surfaces_of
from discretization.fitted.single_contact import SingleContact
from discretization.fitted.states import state_of
from discretization.fitted.tension import pull
from discretization.profile import resolve
from discretization.surfaces.protocol import LinePosition
from energy import FlatPunch, Parabola, Profile


def vee(fall, w):
    """A vee pressed flat but for its corner, at which the slope falls; steep sides."""
    body = Profile(
        lambda x: -fall / 2 * np.abs(x), lambda x: -fall / 2 * np.sign(x), (-9 * L, 9 * L), (0.0,)
    )
    steep = Parabola(0.5 * L)
    outside = Profile(
        lambda x: np.where(np.abs(x) > 6 * L, steep.height(np.abs(x) - 6 * L), 0.0),
        lambda x: np.where(np.abs(x) > 6 * L, np.sign(x) * steep.slope(np.abs(x) - 6 * L), 0.0),
        (-9 * L, 9 * L),
    )
    return adhesive(body + outside, w=w)


@pytest.mark.parametrize("fall", [1e-3, 1e-8])
def test_a_reentrant_corner_stays_open_without_adhesion(fall):
    """ε = J l²/2g to first order, down to lines that have all but met."""
    state = minimise(vee(fall, 0.0), DELTA0)
    assert len(state.contacts) == 2
    first = fall * L**2 / (2 * DELTA0)
    assert state.contacts[1, 0] == pytest.approx(first, rel=1e-2, abs=0)
    assert state.contacts[0, 1] == pytest.approx(-first, rel=1e-2, abs=0)


def motion_of(scene, depth, top=4 * DELTA0):
    """How lines move, over a profile that is known up to a depth."""
    return ContactLines.of(scene, resolve(scene, top), depth)


def judged(state, lines):
    contact_lines = motion_of(state.scene, state.depth)
    contacts = Contacts(contact_lines, tuple(np.ravel(lines).tolist()), state.depth)
    return certify(contacts, contacts.totals())


@pytest.mark.parametrize("line", [0, 1])
@pytest.mark.parametrize("name", ["closing", "opening"])
def test_a_line_whose_rest_depth_is_nan_fails(line, name, monkeypatch):
    contact = SingleContact.of(adhesive(Parabola(0.02)))
    contacts = Contacts(contact, contact.lines(DELTA0), DELTA0)
    found = contacts.totals()
    assert certify(contacts, found).ok
    line_states = list(contacts.line_states)
    line_states[line] = line_states[line]._replace(**{name: math.nan})
    monkeypatch.setattr(SingleContact, "line_states", lambda self, lines, depth: line_states)
    unknown = Contacts(contact, contacts.lines, DELTA0)
    assert "neighbours" in certify(unknown, found).failures


@pytest.mark.parametrize("surface", [0, 1])
def test_a_surface_whose_residual_is_nan_fails(surface, monkeypatch):
    contact = SingleContact.of(adhesive(Parabola(0.02)))
    contacts = Contacts(contact, contact.lines(DELTA0), DELTA0)
    found = contacts.totals()
    surfaces = list(contacts.surfaces)
    surfaces[surface] = surfaces[surface]._replace(residual=math.nan)
    monkeypatch.setattr(Contacts, "surfaces", surfaces)
    unknown = Contacts(contact, contacts.lines, DELTA0)
    assert certify(unknown, found).failures == ("stationarity",)


@pytest.mark.slow
@pytest.mark.parametrize(("share", "failures"), [(0.9, ()), (1.1, ("opening",))])
def test_a_corner_is_torn_open_beyond_what_both_its_lines_hold(share, failures):
    """J <= 2√(2w/γ₁)."""
    free = minimise(vee(share * 2 * ALPHA, 0.002), DELTA0, rtol=1e-6)
    assert len(free.contacts) == 1 + len(failures)
    assert judged(free, [free.contacts[0, 0], free.contacts[-1, 1]]).failures == failures


def test_a_point_of_contact_holds_while_it_is_pressed():
    """Where it is pulled it lets go, as it does not adhere."""
    c = 60 * L
    for share, failures in ((0.3, ()), (-0.1, ("opening",))):
        pressed = minimise(adhesive(tips(c)), 0.3 * DELTA0)
        assert pressed.contacts.tolist() == [[-c, -c], [c, c]]
        state = replace(pressed, depth=share * DELTA0)
        assert judged(state, [-c, -c, c, c]).failures == failures


def test_an_unstable_pair_of_lines_is_no_equilibrium():
    """Lines on ripples where d = f + l (f' - √(2w/γ₁)), Eq. (16), falls outwards."""
    scene = adhesive(rippled(0.015, 0.4 * L, 0.04 * DELTA0, (-8 * L, 8 * L)))
    x = np.linspace(0.05 * L, 4 * L, 4001)
    d = scene.indenter.height(x) + L * scene.indenter.slope(x) - DELTA0
    for rate, failures in ((np.gradient(d), ()), (-np.gradient(d), ("neighbours",))):
        i = int(np.argmax(rate))
        one = minimise(scene, float(d[i]))
        state = replace(one, contacts=np.array([[-x[i], x[i]]]))
        assert judged(state, [-x[i], x[i]]).failures == failures


def test_penetration_between_the_points_is_found():
    """Next to the largest of very many."""
    state = minimise(wavy(crests=10), 2.3 * DELTA0)
    missing = replace(state, contacts=np.delete(state.contacts, 6, axis=0))
    ends = [state.contacts[6, 0] - L, state.contacts[6, 1] + L]
    for _ in range(2):  # everywhere, then next to where it is deepest
        many = np.linspace(*ends, 2001)
        deep = state.depth - state.scene.indenter.height(many) - missing.displacement(many)
        at = int(np.argmax(deep))
        ends = many[[at - 1, at + 1]]
        deepest = deep[at]
    lines = tuple(missing.contacts.ravel().tolist())
    found = motion_of(state.scene, state.depth).penetration(lines, state.depth)
    assert found == pytest.approx(deepest, rel=1e-8, abs=0)


def test_a_flat_surface_that_the_indenter_has_passed_is_rejected():
    contact_lines = motion_of(wavy(), DELTA0, DELTA0)
    for depth, rejected in (
        (0.999 * contact_lines.profile.touch, False),
        (1.001 * contact_lines.profile.touch, True),
    ):
        with pytest.raises(NotCertifiedError) if rejected else contextlib.nullcontext():
            state_of(contact_lines, (), depth, "global")


def test_a_line_about_to_reach_the_edge_of_the_body_has_errors():
    edge = 2 * L
    depth = 2 * DELTA0
    contact_lines = motion_of(adhesive(Parabola(0.02) + FlatPunch(edge)), depth, depth)
    contacts = Contacts(contact_lines, (-edge, edge * (1 - 1e-15)), depth)
    assert np.isfinite(list(errors(contacts, contacts.totals()).values())).all()


def test_a_gap_is_judged_over_the_displacement_of_both_its_lines():
    surfaces = surfaces_of(adhesive(Parabola(0.02)))
    for part in (0.0, 1e-7, 1e-5, 1e-3):
        one = LinePosition(0.0, -part * DELTA0)
        other = LinePosition(9.5 * L, -0.3 * DELTA0)
        assert surfaces.solve(one, other, 0.0).residual <= 1e-12


MOVED = 1e-6  # of the width of the contact or gap on the other side of a line
DEPTH = 0.22
OTHERS = [("line", "small"), ("line", "finite"), ("axisymmetric", "small")]


@pytest.mark.parametrize(("geometry", "slopes"), OTHERS)
@pytest.mark.parametrize("w", [0.0, 1e-6])
def test_certificate_rejects_wrong_lines_and_contacts(w, geometry, slopes):
    """On waves in a bowl; where adhesion is, it holds a gap closed."""
    scene = plain(rippled(20.0, math.pi, 0.1, (-12, 12)), w=w, gamma1=0.1, slopes=slopes)
    scene = replace(scene, geometry=geometry)
    contact_lines = motion_of(scene, DEPTH, DEPTH)
    lines = contact_lines.adhered(DEPTH)
    assert len(lines) >= 4

    def refused(wrong, *failures):
        with pytest.raises(NotCertifiedError, match=f"violates .*{'.*'.join(failures)}"):
            state_of(contact_lines, wrong, DEPTH, "adhered")

    state_of(contact_lines, lines, DEPTH, "adhered")
    for i, x in enumerate(lines):
        if x == 0 and geometry == "axisymmetric":
            continue  # the axis is no line
        beside = MOVED * min(abs(x - other) for other in lines[max(i - 1, 0) : i + 2] if other != x)
        for side in (-1, 1):
            shrunk = (side > 0) == (i % 2 == 0)
            failures = ("penetration", "neighbours")[w > 0 or not shrunk :]
            refused((*lines[:i], x + side * beside, *lines[i + 1 :]), *failures)
    for i in range(0, len(lines), 2):
        refused(lines[:i] + lines[i + 2 :], "penetration")
    for i in range(1, len(lines) - 1, 2):
        closed = lines[:i] + lines[i + 2 :]
        if w:
            state_of(contact_lines, closed, DEPTH, "adhered")
        else:
            refused(closed, "opening")


LENGTH = 0.5
Q = 2 * math.pi
PRESSED = 0.2
STEEP = 1 + (LENGTH * Q) ** 2  # the pull over k is A - d - A STEEP cos qx


def scene(A):
    """A wave of this amplitude and length 1, over two periods."""
    wave = rippled(math.inf, 1.0, A, (-1.0, 1.0))
    return plain(wave, w=0.0, gamma1=LENGTH**2)


def pulled(A, left, right, depth=PRESSED, **changes):
    """The largest pull between two positions, and where the profile pulls."""
    problem = replace(scene(A), **changes)
    return pull(problem, resolve(problem, depth), left, right, depth)


@pytest.mark.parametrize("excess", [1e-6, 1e-3, 0.1])
def test_a_pull_over_less_than_a_sample_is_seen(excess):
    A = (PRESSED + excess) / (1 + STEEP)  # at x = ±1/2 the pull is A (1 + STEEP) - d
    found = pulled(A, 0.9, 0.1)
    assert found.worst == pytest.approx(excess, rel=0.02, abs=1e-9)
    edge = math.acos((1 - PRESSED / A) / STEEP) / Q
    wide = 2 * (0.5 - edge)
    assert found.ends == pytest.approx((edge, 1 - edge), rel=0, abs=max(0.2 * wide, 1e-4))


def test_what_presses_does_not_pull():
    A = (PRESSED - 1e-9) / (1 + STEEP)
    for found in (pulled(A, -0.9, 0.9), pulled(0.1, -0.02, 0.02), pulled(0.1, 0.5, 0.5)):
        assert found.worst == 0
        assert np.isnan(found.ends).all()


def test_inclined_surfaces_bend_less():
    A = 0.15
    x = 0.3
    f = A * (1 - math.cos(Q * x))
    f1 = A * Q * math.sin(Q * x)
    f2 = A * Q**2 * math.cos(Q * x)
    exact = f - PRESSED - LENGTH**2 * f2 / (1 + f1 * f1) ** 1.5
    found = pulled(A, x - 1e-5, x + 1e-5, slopes="finite").worst
    assert found == pytest.approx(exact, rel=1e-3)
    assert found < 0.8 * pulled(A, x - 1e-5, x + 1e-5).worst


def test_around_an_axis_both_curvatures_count():
    A = 0.1
    r = 0.3
    mean = A * Q**2 * math.cos(Q * r) + A * Q * math.sin(Q * r) / r
    exact = A * (1 - math.cos(Q * r)) - PRESSED - LENGTH**2 * mean
    ends = r - 1e-5, r + 1e-5
    found = [pulled(A, *ends, d, geometry="axisymmetric").worst for d in (-1.0, -2.0)]
    assert found == pytest.approx([exact + PRESSED + 1, exact + PRESSED + 2], rel=1e-3)


@pytest.mark.parametrize("excess", [1.5e-8, 5e-8, 1e-5, 1e-3])
def test_a_gap_opens_however_narrow(excess):
    """Around what pulls by 5e-10 of the depth, √3 times as wide: the pull is a parabola there."""
    A = (PRESSED + excess) / (1 + STEEP)
    problem = scene(A)
    state = minimise(replace(problem, indenter=problem.indenter + FlatPunch(0.9)), PRESSED)
    edge = math.acos((1 - PRESSED / A) / STEEP) / Q
    assert len(state.contacts) == (1 if excess < 4e-8 else 3)
    gaps = state.contacts[1:, 0] - state.contacts[:-1, 1]
    assert gaps == pytest.approx(math.sqrt(3) * 2 * (0.5 - edge), rel=0.02)
