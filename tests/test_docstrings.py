"""help() of the names that a user meets first: its sections, and its examples, which are run."""

import doctest
import inspect

import pytest

import discretization
import energy

FUNCTIONS = (discretization.minimise, discretization.load_path, energy.read_profile)
MADE = (
    *(energy.ElasticLayer, energy.SurfaceEnergies, energy.Scene, energy.Patches, energy.Profile),
    *(energy.FlatPunch, energy.Wedge, energy.Parabola, energy.Circle, energy.PowerLaw),
    *(energy.Sampled, energy.SurfaceEnergies.from_work),
)
FOUND = (discretization.Equilibrium, discretization.History, discretization.Event)
FIRST = (*FUNCTIONS, *MADE, *FOUND, energy.Plane, energy.Assumption)


@pytest.mark.parametrize("thing", FIRST, ids=lambda thing: thing.__qualname__)
def test_help_answers_in_the_sections_of_numpydoc_and_its_examples_run(thing):
    text = inspect.getdoc(thing)
    heads = {
        line
        for line, rule in zip(text.split("\n"), text.split("\n")[1:], strict=False)
        if rule == "-" * len(line) and line
    }
    assert "\n" not in text.split("\n\n")[0] and "Examples" in heads
    assert thing not in (*FUNCTIONS, *MADE) or "Parameters" in heads
    assert thing not in FUNCTIONS or "Raises" in heads
    assert thing not in FOUND or "Attributes" in heads
    if "Parameters" in heads:
        section = text.split("Parameters\n----------\n")[1].split("\n\n")[0]
        told = {
            name.strip()
            for line in section.split("\n")
            if not line.startswith(" ")
            for name in line.split(" : ")[0].split(",")
        }
        assert set(inspect.signature(thing).parameters) <= told | {"given_by_work"}
    known = {}  # what is found goes on from what the functions find
    for one in (*FUNCTIONS[:2], thing) if thing in FOUND else (thing,):
        known |= run(one, known)


def run(thing, known):
    """What the examples of a docstring leave behind, which begin with what is known."""
    text, said = inspect.getdoc(thing), []
    test = doctest.DocTestParser().get_doctest(text, known, thing.__qualname__, None, None)
    assert test.examples
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(test, out=said.append, clear_globs=False)
    assert not said, "".join(said)
    return test.globs


def test_the_returned_things_are_named():
    for function in (discretization.minimise, discretization.load_path):
        returned = inspect.signature(function).return_annotation
        assert f"Returns\n-------\n{returned}\n" in inspect.getdoc(function)
    assert len(FIRST) == 20
