import re
from pathlib import Path

import numpy as np

PAGE = Path(__file__).parents[3] / "docs/governor.md"


def test_the_example_of_the_page_runs_and_keeps_its_limits(capsys):
    (code,) = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    names: dict = {}
    exec(compile(code, str(PAGE), "exec"), names)
    assert "rests at 0.9" in capsys.readouterr().out
    assert (names["largest"] <= [1.0, 0.5, 2.0]).all()
    assert (names["largest"][:2] > [0.95, 0.45]).all()
    assert np.isclose(names["largest"][2], 2.0, rtol=0.02)
