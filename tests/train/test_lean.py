"""Each cheaper piece gives what rsl_rl's or torch's own gives."""

import pytest

torch = pytest.importorskip("torch")

from rsl_rl.modules import EmpiricalNormalization  # noqa: E402
from rsl_rl.modules.distribution import GaussianDistribution  # noqa: E402
from torch import nn  # noqa: E402

from mobius.train.lean import LeanElu, LeanGaussian, learn_moments, use_lean_elu  # noqa: E402


def test_the_lean_elu_is_elu():
    x = torch.linspace(-20, 5, 10001, requires_grad=True)
    y = torch.linspace(-20, 5, 10001, requires_grad=True)
    ours, theirs = LeanElu()(x), torch.nn.functional.elu(y)
    torch.testing.assert_close(ours, theirs, rtol=0, atol=2e-7)
    ours.sum().backward()
    theirs.sum().backward()
    torch.testing.assert_close(x.grad, y.grad, rtol=0, atol=2e-7)
    assert torch.isnan(LeanElu()(torch.tensor([torch.nan]))).all()


def test_every_elu_is_replaced_though_it_is_one_module_many_times():
    act = nn.ELU()
    net = nn.Sequential(nn.Linear(2, 2), act, nn.Linear(2, 2), act, nn.Sequential(act))
    x = torch.randn(5, 2)
    want = net(x)
    use_lean_elu(net)
    assert not any(isinstance(m, nn.ELU) for m in net.modules())
    torch.testing.assert_close(net(x), want)


def test_the_lean_gaussian_is_rsl_rl_s():
    torch.manual_seed(0)
    ours, theirs = (
        make(3, init_std=0.6, std_type="log") for make in (LeanGaussian, GaussianDistribution)
    )
    with torch.no_grad():
        for d in (ours, theirs):
            d.log_std_param.copy_(torch.tensor([-1.0, 0.2, 0.5]))
    old = (torch.randn(7, 3), torch.tensor([0.5, 1.0, 2.0]).expand(7, 3))
    actions, results = torch.randn(7, 3), []
    for d in (ours, theirs):
        mean = torch.linspace(-1, 1, 21).reshape(7, 3).requires_grad_()
        d.update(mean)
        kl = d.kl_divergence(old, d.params)
        out = [d.mean, d.std, d.entropy, d.log_prob(actions), kl, *d.params]
        sum(x.square().sum() for x in out).backward()
        torch.manual_seed(3)
        sample = d.sample()
        assert not sample.requires_grad
        results.append([*out, sample, mean.grad, d.log_std_param.grad])
    for a, b in zip(*results, strict=True):
        torch.testing.assert_close(a, b, rtol=1e-5, atol=1e-5)
    assert ours.state_dict().keys() == theirs.state_dict().keys()


def test_the_lean_moments_are_rsl_rl_s():
    torch.manual_seed(0)
    ours, theirs = EmpiricalNormalization(4), EmpiricalNormalization(4)
    for i in range(4):
        x = torch.randn(50 + i, 4) * torch.tensor([1e-3, 1.0, 10.0, 1.0]) + i
        learn_moments(ours, x)
        theirs.update(x)
    for a, b in zip(ours.state_dict().values(), theirs.state_dict().values(), strict=True):
        torch.testing.assert_close(a, b, rtol=1e-5, atol=1e-5)
