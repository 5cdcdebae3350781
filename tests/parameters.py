"""Values to try for a parameter, and the parameters that change nothing."""

import dataclasses

import weftex
from weftex.registry import METHODS


def values_of(field, given):
    """Values that a parameter may have: its bounds, or some around what it is."""
    now = given.get(field.name, field.default)
    low, high = field.metadata["low"], field.metadata["high"]
    if field.metadata["choices"]:
        found = [v for v in field.metadata["choices"] if v != "auto"][:3]
    elif "int" in str(field.type):
        base = now or 8
        found = [base + 2, 2, 3 * base + 6, base // 25, low]
    else:
        base = now or 4.0
        found = [5.0 * base, 0.2 * base, low, high, 100.0]
    allowed = [v for v in found if v is not None and v != now]
    if field.metadata["choices"]:
        return allowed
    return [v for v in allowed if (low is None or v >= low) and (high is None or v <= high)]


def idle(slug, given, changes):
    """Parameters that are taken and change nothing, each with what was tried.

    ``changes(parameters)`` makes what a method makes of all scenes, beside what `given` makes.
    """
    found = []
    for field in dataclasses.fields(METHODS[slug]):
        tried = {}
        for value in values_of(field, given):
            try:
                tried[value] = changes(given | {field.name: value})
            except weftex.InvalidInputError as error:
                tried[value] = str(error)
            if tried[value] is True:
                break
        if True not in tried.values() and False in tried.values():
            found.append((field.name, tried))
    return found
