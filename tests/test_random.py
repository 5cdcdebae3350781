"""Random bits: the contract between a seed and the bytes that it makes."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from families import refused
from twins import randomness as reference
from weftex.random import draw, seed_number

MASK = 2**64 - 1


def test_the_mixing_function_is_splitmix64():
    """The first outputs of SplitMix64 seeded with 0 and 1234567, as published with it."""
    from weftex.random import _mix

    assert int(_mix(np.array([0], np.uint64))[0]) == 0xE220A8397B1DCDAF
    assert int(_mix(np.array([1234567], np.uint64))[0]) == 6457827717110365317
    for state in (1, 2**63, MASK):
        assert int(_mix(np.array([state], np.uint64))[0]) == reference.splitmix(state)


@given(
    st.integers(0, MASK),
    st.text(max_size=8),
    st.lists(st.integers(-(2**63), 2**63 - 1), max_size=4),
)
def test_it_is_the_slow_twin(seed, purpose, place):
    assert int(draw(seed, purpose, *place)) == reference.random_bits(seed, purpose, *place)


def test_places_broadcast():
    y, x = np.indices((3, 4))
    whole = draw(7, "patch", y, x)
    assert whole.shape == (3, 4) and whole.dtype == np.uint64
    for i, j in itertools.product(range(3), range(4)):
        assert draw(7, "patch", i, j).shape == ()
        assert draw(7, "patch", i, j) == whole[i, j]
    assert np.array_equal(draw(7, "patch", y[:, :1], x[:1]), whole)


def test_any_integer_type_and_sign_is_a_place():
    for dtype in (np.int8, np.int32, np.int64, np.uint8):
        assert draw(1, "a", np.array(5, dtype)) == draw(1, "a", 5)
    assert draw(1, "a", -1) != draw(1, "a", 1)
    assert len({int(draw(1, "a", k)) for k in range(-500, 500)}) == 1000


@pytest.mark.parametrize(
    "one, other",
    [
        ((1, "patch", 3, 4), (2, "patch", 3, 4)),
        ((1, "patch", 3, 4), (1, "patch", 4, 3)),
        ((1, "patch", 3, 4), (1, "hole", 3, 4)),
        ((1, "patch", 3), (1, "patch", 3, 0)),
        ((1, "patch", 0), (1, "patch", 0, 0)),
        ((4, "a", 0), (7, "b", 0)),  # seeds that differ as the purposes' letters do
        ((1, "ab", 1), (1, "a", ord("b"), 1)),  # a place that spells the rest of a purpose
        ((1, "ab", 1), (1, "a", ord("b"), 0xFF, 1)),
        ((1, "a"), (1, "", ord("a"))),
        ((1, "a", 0xFF), (1, "a")),
        ((1, "\xff", 1), (1, "", 0xC3, 0xBF, 1)),
        ((0, "a", 0), (3, "b", 3)),  # both differ by the same bits
    ],
)
def test_different_questions_have_different_answers(one, other):
    assert draw(*one) != draw(*other)


def test_seed_numbers():
    assert seed_number(0) == 0
    assert seed_number(MASK) == MASK
    assert seed_number(np.int64(5)) == 5 and isinstance(seed_number(np.int64(5)), int)
    assert seed_number(np.uint64(MASK)) == MASK
    one, other = np.random.default_rng(1), np.random.default_rng(1)
    assert seed_number(one) == seed_number(other)
    assert seed_number(one) != seed_number(np.random.default_rng(1))  # it moved on
    assert seed_number(None) != seed_number(None)


@pytest.mark.parametrize("seed", [-1, 2**64, 1.0, "7", True, [1], np.nan])
def test_bad_seeds_are_refused(seed):
    refused("seed is", seed_number, seed)


def test_frozen_values():
    """These must never change: people keep seeds, not pictures."""
    assert [int(k) for k in draw(7, "patch", 3, [0, 4])] == FROZEN[7]
    assert [int(k) for k in draw(MASK, "patch", -1, [0, 4])] == FROZEN[MASK]


FROZEN = {7: [4264518668862947853, 3951045938428809832]}
FROZEN[MASK] = [1461213734136769179, 7027295519210459609]
