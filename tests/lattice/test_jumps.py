"""Lines that jump on nodes: all links at once, and surfaces followed by themselves."""

import numpy as np
import pytest
from support.example_scenes import rough

from discretization.lattice import walk as walks
from discretization.lattice.loss import ContactLoss
from discretization.lattice.walk import Walk
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Row
from discretization.refine.lives import pairs

USUAL_JUMPING = walks._JUMPING


def links_in(contacts):
    """Links of contacts, which are first and last nodes."""
    return sum(last - first for first, last in contacts)


def links(lines):
    """Links between the nodes of lines, from left to right."""
    return sum(lines[1::2]) - sum(lines[::2])


def rows(seed, nodes):
    scene = rough(seed)
    lattice = Lattice.of(scene, scene.elastocapillary_length / nodes)
    deep = 3 * scene.critical_separation
    return scene, Row.of(lattice.scene_on_nodes(scene), lattice, deep), deep


def tracks(row, deep, low):
    """All events in and out."""
    walk = Walk(row)
    found = []
    for start, end, contacts in ((row.lowest, deep, None), (deep, low, None)):
        contacts = walk.touched(start) if not found else found[-1][2]
        at = start
        while at is not None and contacts:
            track = walk.track(contacts, at, end)
            at = track.at
            contacts = track.after
            found.append((at, track.trace[-1][1], contacts))
    return found


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_a_jump_of_all_links_at_once_ends_where_single_links_do(seed, monkeypatch):
    scene, row, deep = rows(seed, 64)
    low = row.lowest - 3 * scene.critical_separation
    at_once = tracks(row, deep, low)
    monkeypatch.setattr(walks, "_JUMPING", 10**9)  # a line that jumps passes link after link
    assert tracks(row, deep, low) == at_once
    assert len(at_once) > 6
    passed = [abs(links_in(after) - links(before)) for _, before, after in at_once]
    assert max(passed) > 10 * USUAL_JUMPING


def test_a_surface_alone_moves_as_among_others():
    _, row, deep = rows(2, 64)
    walk = Walk(row)
    contacts = walk.moved(walk.touched(row.lowest), row.lowest, deep / 2)
    assert len(contacts) > 1
    step = deep / 200
    for end in (deep / 2 + step, deep / 2 - step):
        whole = walk.track(contacts, deep / 2, end)
        assert whole.at is None
        now = np.array(whole.after)
        for k, pair in enumerate(pairs(contacts)):
            beside = pairs(contacts)[max(k - 1, 0) : k + 2] if end < deep / 2 else [pair]
            alone = walk.track_part(beside, deep / 2, end)
            mine = [p for p in pairs(alone.after) if p == pairs(whole.after)[k]]
            assert len(mine) == 1
    assert now.size


@pytest.mark.parametrize("distance", [0.0, 0.3, 1.0])
def test_no_line_rests_where_no_surface_is_left(distance):
    """A step of Newton's method may lead there; it ended in an error of the square root."""
    _, row, _ = rows(1, 16)
    loss = ContactLoss(row, row.thresholds[1])
    x = row.size // 2 + 0.5
    assert np.isnan(loss.rest_depth(x, 1, x - 0.5 + distance))
    assert np.isfinite(loss.rest_depth(x, 1, x - 0.5 + 2.0))
