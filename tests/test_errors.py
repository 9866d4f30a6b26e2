"""Errors that cross to another process."""

import pickle

import pytest

from mobius.errors import InvalidInput, MapError, MissingDependency, UnknownName


@pytest.mark.parametrize(
    "error",
    [
        InvalidInput("what"),
        MapError("where"),
        UnknownName("mode", "fly", ["crawl", "biped"]),
        MissingDependency("torch", "train", "training"),
    ],
)
def test_an_error_says_the_same_in_another_process(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error) and str(again) == str(error)
    assert again.__dict__ == error.__dict__
