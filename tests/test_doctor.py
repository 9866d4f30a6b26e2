"""The doctor: a sound machine is left alone, a broken one is told what to type."""

import json
from dataclasses import replace

import pytest

from mobius import doctor
from mobius.doctor import Facts, Report, diagnose

SOUND = Facts(
    mobius="0.1.0",
    python="3.11.7",
    platform="Linux x86_64",
    cpus=2,
    core={"numpy": "2.4.6", "mujoco": "4.0.0", "onnxruntime": "1.32.0"},
    extras={"train": {"torch": "2.13.0+cpu"}},
    out_of_range={},
    broken={},
    gl={"egl": "", "osmesa": "no library"},
    gl_chosen="",
    sparse_models=(),
    model_error="",
    torch_cuda="",
    gpu=False,
)


def only(**changes: object) -> tuple[str, str, str]:
    """Level, subject and message of the one finding that ``changes`` cause."""
    (finding,) = diagnose(replace(SOUND, **changes))  # type: ignore[arg-type]
    return finding.level, finding.about, finding.message


def test_a_sound_machine_has_no_findings_and_exit_code_0():
    report = Report(SOUND, diagnose(SOUND))
    assert report.findings == ()
    assert report.exit_code == 0
    assert report.text().endswith("nothing to complain about")


@pytest.mark.parametrize(
    ("changes", "level", "about", "message"),
    [
        (
            {"core": {**SOUND.core, "scipy": None}},
            "error",
            "scipy",
            "is not installed. Type: make install",
        ),
        (
            {"broken": {"onnxruntime": "ImportError: numpy.core.multiarray failed to import"}},
            "error",
            "onnxruntime",
            "cannot be used (ImportError: numpy.core.multiarray failed to import)."
            " Type: pip install --force-reinstall onnxruntime",
        ),
        (
            {"out_of_range": {"mujoco": "<4.1,>=4.0"}},
            "error",
            "mujoco",
            "is outside the range <4.1,>=4.0. Type: pip install 'mujoco<4.1,>=4.0'",
        ),
        (
            {"out_of_range": {"torch": ">=2.8"}},
            "warning",
            "torch",
            "is outside the range >=2.8. Type: pip install 'torch>=2.8'",
        ),
        (
            {"extras": {"train": {"torch": None}}},
            "note",
            "extra 'train'",
            "lacks torch; to have it, type: pip install 'mobius[train]'",
        ),
        (
            {"sparse_models": ("scene.xml",)},
            "error",
            "mujoco",
            "4.0.0 solves sparse Jacobians wrongly and scene.xml would be sparse."
            ' Write: <option jacobian="dense"/>',
        ),
        (
            {"model_error": "ValueError: XML Error"},
            "error",
            "robot model",
            "does not load (ValueError: XML Error). Type: make clean install",
        ),
        (
            {"torch_cuda": "13.0"},
            "note",
            "torch",
            "is built for CUDA 13.0 and there is no GPU: training works on the CPU, the CPU"
            " build would save some gigabytes",
        ),
        (
            {"gl": {"egl": "no library", "osmesa": "no library"}},
            "warning",
            "OpenGL",
            "no back end draws, so runs leave no video. Debian: apt install libegl1 libgl1",
        ),
        (
            {"gl_chosen": "osmesa"},
            "warning",
            "OpenGL",
            "MUJOCO_GL=osmesa does not draw. Type: export MUJOCO_GL=egl",
        ),
    ],
)
def test_each_trouble_is_named_with_what_to_type(changes, level, about, message):
    assert only(**changes) == (level, about, message)


def test_the_sparse_bug_is_4_0_0s_alone():
    later = {**SOUND.core, "mujoco": "4.0.1"}
    assert diagnose(replace(SOUND, core=later, sparse_models=("scene.xml",))) == ()


def test_a_cuda_torch_on_a_machine_with_a_gpu_is_fine():
    assert diagnose(replace(SOUND, torch_cuda="13.0", gpu=True)) == ()


def test_only_an_error_makes_the_exit_code_1_and_it_comes_first():
    facts = replace(SOUND, gl={"egl": "no"}, extras={"train": {"torch": None}})
    assert Report(facts, diagnose(facts)).exit_code == 0
    facts = replace(facts, broken={"numpy": "ImportError"})
    report = Report(facts, diagnose(facts))
    assert report.exit_code == 1
    assert [f.level for f in report.findings] == ["error", "warning", "note"]


def test_json_round_trips_and_says_ok():
    facts = replace(SOUND, broken={"numpy": "ImportError"})
    out = json.loads(json.dumps(Report(facts, diagnose(facts)).as_dict()))
    assert out["ok"] is False
    assert out["facts"]["core"]["mujoco"] == "4.0.0"
    assert out["findings"][0]["about"] == "numpy"


@pytest.mark.parametrize(("broken", "code"), [({}, 0), ({"numpy": "ImportError"}, 1)])
def test_the_verb_prints_one_json_object_and_returns_the_exit_code(
    monkeypatch, capsys, broken, code
):
    monkeypatch.setattr(doctor, "gather", lambda: replace(SOUND, broken=broken))
    assert doctor.main(as_json=True) == code
    assert json.loads(capsys.readouterr().out)["ok"] is (code == 0)


def test_requirements_are_those_of_the_installed_package():
    groups = doctor._requirements()
    assert {"numpy", "mujoco", "tyro"} <= {r.name for r in groups[""]}
    assert "torch" in {r.name for r in groups["train"]}
    assert "torch" not in {r.name for r in groups[""]}


def test_a_probe_that_crashes_is_an_error_line_and_not_our_crash():
    assert doctor._run("print('fine')") == ("fine\n", "")
    assert doctor._run("import no_such_package")[1] == (
        "ModuleNotFoundError: No module named 'no_such_package'"
    )
    assert doctor._run("import os; os._exit(11)")[1] == "ended with code 11"


def test_a_probe_sees_the_environment_it_is_given():
    out, _ = doctor._run("import os; print(os.environ['MUJOCO_GL'])", MUJOCO_GL="osmesa")
    assert out == "osmesa\n"


def test_a_probe_that_hangs_is_given_up(monkeypatch):
    monkeypatch.setattr(doctor, "PROBE_LIMIT_S", 0.2)
    assert doctor._run("import time; time.sleep(30)")[1] == "no answer within 0.2 s"
