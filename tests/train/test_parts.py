"""A network in parts: the same values and gradients, the same bits on any number of threads."""

import threading

import pytest

torch = pytest.importorskip("torch")

from torch import nn  # noqa: E402

from mobius.train.parts import PARTS, Workers, in_parts  # noqa: E402


class TwoInTwoOut(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.layer = nn.Linear(5, 3)

    def forward(self, a: torch.Tensor, b: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
        return torch.tanh(self.layer(a)), self.layer(b)


def run(workers: Workers | None, n: int) -> list[torch.Tensor]:
    torch.manual_seed(0)
    net, a, b = TwoInTwoOut(), torch.randn(n, 5), torch.randn(n, 5)
    out = net(a, b) if workers is None else in_parts(workers, net, a, b)
    (out[0].square().sum() + out[1].sum()).backward()
    return [*out, net.layer.weight.grad, net.layer.bias.grad]


@pytest.mark.parametrize("n", [8, 7, PARTS])
def test_parts_give_what_the_whole_gives(n):
    for a, b in zip(run(Workers(1), n), run(None, n), strict=True):
        torch.testing.assert_close(a, b)


def test_the_number_of_threads_changes_no_bit():
    for a, b in zip(run(Workers(1), 1001), run(Workers(3), 1001), strict=True):
        assert torch.equal(a, b)


def test_parts_run_side_by_side_and_results_keep_their_order():
    meet = threading.Barrier(2, timeout=10)

    def work(i: int) -> int:
        meet.wait()  # passes only while both are under way
        return i

    assert Workers(2).map(work, 2) == [0, 1]


def test_work_begun_beside_gives_its_result_or_its_error():
    gate = threading.Event()
    later = Workers(2).begin(lambda: gate.wait(10))
    gate.set()  # reached while the work waits
    assert later() is True
    assert Workers(1).begin(lambda: 5)() == 5
    with pytest.raises(ZeroDivisionError):
        Workers(2).begin(lambda: 1 // 0)()
