"""``mobius drive`` at the command line: where its token comes from."""

from types import SimpleNamespace

import pytest

from mobius.cli import main

OPTION, VARIABLE = "given-as-an-option", "given-in-the-environment"


@pytest.mark.parametrize(
    ("variable", "words", "token"),
    [
        (VARIABLE, (), VARIABLE),
        (VARIABLE, ("--token", OPTION), OPTION),
        (VARIABLE, ("--host", "127.0.0.1"), VARIABLE),
        ("", ("--host", "127.0.0.1"), ""),
        ("", ("--token", OPTION), OPTION),
    ],
)
def test_the_token_of_the_environment_is_taken_where_the_option_is_not_given(
    variable, words, token, monkeypatch
):
    doors = []
    monkeypatch.setattr(
        "mobius.drive.run.drive",
        lambda _, *, door, **__: doors.append(door) or SimpleNamespace(last=None),
    )
    monkeypatch.setenv("MOBIUS_TOKEN", variable)
    host = () if "--host" in words else ("--host", "0.0.0.0")
    assert main(["drive", *host, *words]) == 0
    assert doors[0].token == token


def test_a_variable_that_cannot_be_a_token_is_named(monkeypatch, capsys):
    monkeypatch.setattr("mobius.drive.run.drive", lambda *_, **__: SimpleNamespace(last=None))
    monkeypatch.setenv("MOBIUS_TOKEN", "sixteen letters; and a blank")
    assert main(["drive", "--host", "0.0.0.0"]) == 2
    err = capsys.readouterr().err
    assert "MOBIUS_TOKEN: expected letters" in err and err.count("\n") == 1
