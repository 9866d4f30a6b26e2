"""The shipped motions are what the designs make of the kept numbers."""

import json
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from mobius.choreography import designs, keys
from mobius.choreography.designs import DESIGNS, as_document, design_of, read_numbers
from mobius.choreography.rear import crawl_to_stand, stand_to_crawl
from mobius.errors import InvalidInput, UnknownName
from mobius.modes.motions import Tilt, read_motion

DATA = Path(str(resources.files("mobius.modes.motions") / "data"))


@pytest.mark.parametrize("name", DESIGNS)
def test_a_shipped_motion_is_built_from_its_numbers(name: str):
    built = as_document(DESIGNS[name].build(read_numbers(DESIGNS[name])))
    shipped = json.loads((DATA / f"{name}.json").read_text())
    assert _plain(built) == pytest.approx(_plain(shipped), abs=2e-5)
    assert [len(s) for s in built["stages"]] == [len(s) for s in shipped["stages"]]


def _plain(document: dict) -> list[float]:
    """All numbers of a document in their order; another processor's libm may round otherwise."""

    def walk(value: object) -> list[float]:
        if isinstance(value, dict):
            return [x for v in value.values() for x in walk(v)]
        if isinstance(value, list):
            return [x for v in value for x in walk(v)]
        return [float(value)] if isinstance(value, int | float) else []

    return walk(document)


def test_lying_down_goes_the_way_of_standing_up_backwards():
    numbers = read_numbers(DESIGNS["crawl_to_stand"])
    up, down = crawl_to_stand(numbers), stand_to_crawl(numbers)
    np.testing.assert_allclose(up.stages[4].q, down.stages[0].q, atol=1e-9)


def test_numbers_lie_within_their_ranges():
    for design in DESIGNS.values():
        numbers = read_numbers(design)
        for key, (low, high, _) in design.ranges.items():
            assert low - 1e-5 <= numbers[key] <= high + 1e-5, (design.name, key)


def test_a_number_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    (tmp_path / "rear.json").write_text("{}")
    monkeypatch.setattr(designs, "numbers_file", lambda name: tmp_path / f"{name}.json")
    with pytest.raises(InvalidInput, match=r"'arms' in rear\.json"):
        read_numbers(DESIGNS["crawl_to_stand"])
    with pytest.raises(UnknownName, match="roll"):
        design_of("rol")


def test_a_document_reads_back_as_the_same_motion(tmp_path: Path):
    design = DESIGNS["roll"]
    motion = design.build(read_numbers(design))
    path = tmp_path / "roll.json"
    path.write_text(json.dumps(as_document(motion)))
    again = read_motion(path)
    for a, b in zip(motion.stages, again.stages, strict=True):
        np.testing.assert_allclose(a.q, b.q, atol=1e-6)
        np.testing.assert_allclose(a.through, b.through, atol=1e-6)
        assert a.until == b.until


def test_mirrored_poses_mirror_and_stay_within_limits():
    q = keys.within_limits(keys.mirrored(keys.HIGH))
    np.testing.assert_allclose(keys.left_side(q)[0], -q[6])
    np.testing.assert_allclose(keys.left_side(q)[1:4], q[7:10])


@pytest.mark.parametrize("name", ["supine_to_crawl", "supine_recovery", "prone_to_crawl"])
def test_what_stirs_a_heap_may_begin_in_any_heap(name: str):
    """Lying askew the recovery plays these; a guard on the first stage would end each at once."""
    design = DESIGNS[name]
    window = design.build(read_numbers(design)).stages[0].window
    assert window is not None
    for pitch in np.linspace(-np.pi, np.pi, 13):
        for lean in np.linspace(-1.5, 1.5, 7):
            assert window.holds(Tilt(float(pitch), 0.0, float(lean)))
