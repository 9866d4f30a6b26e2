"""The example of docs/force-control.md runs and tells what it promises."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[3] / "docs" / "force-control.md"


def test_the_example_runs_and_10_n_give_way_by_50_mm_on_200_n_per_m(capsys):
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    exec(compile(code, str(PAGE), "exec"), {})
    assert capsys.readouterr().out == "gives way by 49.9 mm\n"
