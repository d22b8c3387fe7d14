#!/usr/bin/python3
# Makes tests/nn/torch_figures.inc: what PyTorch computes, in double, for the cases of tests/nn/torch.cpp.
# Inputs and weights come from a formula that both sides share, rounded to float. Run with Debian 12's python3-torch
# (1.13): /usr/bin/python3 tests/nn/torch_figures.py > tests/nn/torch_figures.inc
import math

import numpy as np
import torch
import torch.nn.functional as F

LAYERS = [  # number of the inputs, name, input shape, batch, layer
    (0, "conv1x1", (5, 4, 6), 3, "conv 7 1x1"),
    (2, "conv3x3pad1", (17, 6, 5), 16, "conv 18 3x3 pad 1"),
    (4, "conv5x3pad1x2", (2, 8, 9), 3, "conv 3 5x3 pad 1x2"),
    (6, "conv3x3stride2x1", (3, 8, 7), 5, "conv 4 3x3 stride 2x1 pad 0x1"),
    (7, "conv5x5stride3pad4", (2, 10, 11), 16, "conv 3 5x5 stride 3 pad 4"),
    (8, "conv1x1stride2", (3, 7, 8), 33, "conv 4 1x1 stride 2"),
    (9, "relu", (3, 4, 5), 17, "relu"),
    (10, "maxpool2", (3, 8, 7), 17, "maxpool 2"),
    (12, "maxpool2x3", (3, 6, 8), 16, "maxpool 2x3 stride 1x2"),
    (13, "avgpool2", (3, 8, 7), 17, "avgpool 2"),
    (15, "avgpool2stride3", (3, 8, 9), 16, "avgpool 2 stride 3"),
    (16, "globalavgpool", (5, 7, 6), 19, "globalavgpool"),
    (17, "fc", (4, 5, 6), 19, "fc 7"),
    (18, "fcmany", (3, 1, 2), 35, "fc 40"),
    (20, "depthwise", (5, 7, 6), 3, "conv 5 3x3 stride 2 pad 1 groups 5"),
    (21, "dilation2x3", (4, 9, 8), 17, "conv 6 3x2 pad 2x1 groups 2 dilation 2x3"),
    (22, "dilation5x1", (3, 12, 1), 16, "conv 4 3x1 pad 4x0 dilation 5x1"),
    (23, "maxpool3pad1", (3, 9, 8), 17, "maxpool 3 stride 2 pad 1"),
    (24, "avgpool3pad1", (3, 9, 8), 5, "avgpool 3 stride 2 pad 1"),
    (25, "leakyrelu", (3, 4, 5), 17, "leakyrelu 0.125"),
    (26, "tanh", (3, 4, 5), 17, "tanh"),
    (27, "sigmoid", (3, 4, 5), 17, "sigmoid"),
    (28, "gelu", (3, 4, 5), 17, "gelu"),
    (29, "layernorm", (6, 4, 5), 19, "layernorm"),
    (30, "layernormflat", (33, 1, 1), 3, "layernorm"),
    (31, "statspool", (5, 7, 6), 19, "statspool"),
    (32, "residual", (3, 5, 4), 17, "residual { conv 3 3x3 pad 1; tanh }"),
    (33, "concat", (3, 5, 4), 17, "concat { conv 2 1x1; sigmoid }"),
]
NONLINEAR = ("tanh", "sigmoid", "gelu", "layernorm", "statspool", "residual", "concat")
NETWORK = ("conv 4 3x3 pad 1", "batchnorm", "relu", "maxpool 2", "conv 6 3x3 stride 2x1 pad 1", "batchnorm", "relu",
           "avgpool 2", "fc 3")
NETWORK_SHAPE, NETWORK_BATCH, STEPS = (2, 12, 10), 19, 5
LEARNING_RATE, MOMENTUM, WEIGHT_DECAY = 0.0625, 0.875, 0.03125  # exact in float


def hashed(identity, count):
    """Numbers in [-1, 1): tests/nn/chain.hpp has the same."""
    with np.errstate(over="ignore"):
        h = np.arange(count, dtype=np.uint32) * np.uint32(0x9E3779B9)
        h += np.uint32((identity * 0x85EBCA6B + 0x1234567) % 2**32)
        h = (h ^ (h >> np.uint32(16))) * np.uint32(0x7FEB352D)
        h = (h ^ (h >> np.uint32(15))) * np.uint32(0x846CA68B)
        h ^= h >> np.uint32(16)
    return (h >> np.uint32(8)).astype(np.float64) * 2.0**-23 - 1.0


def tensor(identity, shape, scale=1.0, offset=0.0):
    values = (offset + scale * hashed(identity, math.prod(shape))).astype(np.float32)
    return torch.from_numpy(values.astype(np.float64)).reshape(shape).requires_grad_()


def pair(word):
    rows, _, columns = word.partition("x")
    return int(rows), int(columns or rows)


def option(words, name, default):
    return pair(words[words.index(name) + 1]) if name in words else default


def block(line):
    """The lines in the braces."""
    return [inner.strip() for inner in line[line.index("{") + 1:line.index("}")].split(";")]


def parameters(line, shape, identity):
    words = line.split()
    if words[0] in ("residual", "concat"):  # the first line of each block here is the only one with weights
        return parameters(block(line)[0], shape, identity)
    if words[0] == "conv":
        size = (int(words[1]), shape[0] // option(words, "groups", (1, 1))[0], *pair(words[2]))
        return {"weight": tensor(identity, size, 0.5), "bias": tensor(identity + 1, size[:1])}
    if words[0] == "fc":
        size = (int(words[1]), math.prod(shape))
        return {"weight": tensor(identity, size, 0.5), "bias": tensor(identity + 1, size[:1])}
    if words[0] in ("batchnorm", "layernorm"):
        return {"gamma": tensor(identity, shape[:1], 0.5, 1.0), "beta": tensor(identity + 1, shape[:1])}
    return {}


def apply(line, x, p, statistics=None, training=True):
    words = line.split()
    if words[0] in ("residual", "concat"):
        y = x
        for inner in block(line):
            y = apply(inner, y, p)
        return x + y if words[0] == "residual" else torch.cat((x, y), 1)
    if words[0] == "statspool":
        return torch.cat((x.mean((2, 3), keepdim=True), (x.var((2, 3), unbiased=False, keepdim=True) + 1e-5).sqrt()), 1)
    if words[0] == "conv":
        return F.conv2d(x, p["weight"], p["bias"], stride=option(words, "stride", (1, 1)),
                        padding=option(words, "pad", (0, 0)), groups=option(words, "groups", (1, 1))[0],
                        dilation=option(words, "dilation", (1, 1)))
    if words[0] == "fc":
        return F.linear(x.flatten(1), p["weight"], p["bias"])[:, :, None, None]
    if words[0] == "batchnorm":
        return F.batch_norm(x, *statistics, p["gamma"], p["beta"], training=training, momentum=0.1, eps=1e-5)
    if words[0] == "layernorm":
        return F.group_norm(x, 1, p["gamma"], p["beta"], eps=1e-5)
    if words[0] == "leakyrelu":
        return F.leaky_relu(x, float(words[1]))
    if words[0] in ("relu", "tanh", "sigmoid", "gelu"):
        return getattr(torch if words[0] in ("tanh", "sigmoid") else F, words[0])(x)
    if words[0] == "globalavgpool":
        return F.adaptive_avg_pool2d(x, 1)
    pool = F.max_pool2d if words[0] == "maxpool" else F.avg_pool2d
    return pool(x, pair(words[1]), stride=option(words, "stride", pair(words[1])), padding=option(words, "pad", (0, 0)))


def emit(name, values, length, magnitude):
    """A line: the tensor's name, the length of its sums, the largest sum of absolute values, all of it projected on
    one direction, and up to 24 of its values."""
    values = values.detach().numpy().ravel()
    index = np.arange(values.size)
    if values.size > 24:
        index = ((hashed(77, 24) + 1) / 2 * values.size).astype(int)
    projection = float(np.dot(values, hashed(99, values.size)))
    listed = ", ".join(f"{v:.12g}" for v in values[index])
    print(f'{{"{name}", {length}, {float(magnitude):.4g}, {projection:.12g}, {{{listed}}}}},')


def layer_figures(number, name, shape, batch, line):
    first = 100 * number
    kind = line.split()[0]

    def run(absolute):
        x = tensor(first, (batch, *shape), 1.5, 0.2)
        p = parameters(line, shape, first + 10)
        if absolute:  # the layers here are linear in each of x, weights and diff_dst: this sums the terms' magnitudes
            x = x.detach().abs().requires_grad_()
            p = {k: v.detach().abs().requires_grad_() for k, v in p.items()}
        y = apply(line, x, p)
        dy = tensor(first + 1, y.shape).detach()
        y.backward(dy.abs() if absolute else dy)
        return {"dst": y, "diff_src": x.grad, **{k: v.grad for k, v in p.items()}}

    exact, terms = run(False), run(True)
    if kind in NONLINEAR:  # computed in double and rounded once; gradients of parameters are sums over the batch
        for key, values in exact.items():
            emit(f"{name}/{key}", values, 4, batch * math.prod(shape[1:]) if key in ("gamma", "beta", "weight", "bias") else values.abs().max())
        return
    plane = exact["dst"].shape[2] * exact["dst"].shape[3]
    if kind in ("conv", "fc"):
        inputs = terms["weight"].shape[1:].numel()
        taps = terms["weight"].numel() // (shape[0] if kind == "conv" else math.prod(shape))
        blocks = (batch + 15) // 16
        length = {"dst": inputs + 1, "diff_src": taps, "weight": plane + 4 + blocks, "bias": plane + 4 + blocks}
    elif kind in ("avgpool", "globalavgpool"):
        window = pair(line.split()[1]) if kind == "avgpool" else shape[1:]
        length = {"dst": window[0] * window[1] + 2, "diff_src": window[0] * window[1] + 2}
    else:  # copies; overlapping windows add up
        length = {"dst": 0, "diff_src": 0 if kind == "relu" else 9}
    if kind == "leakyrelu":
        length = {"dst": 1, "diff_src": 1}
    for key, values in exact.items():
        emit(f"{name}/{key}", values, length[key], terms[key].abs().max())


def batchnorm_figures():
    """Three steps of training, then inference: channels with an offset of up to four deviations."""
    shape, batch, first = (9, 5, 6), 19, 5000
    p = parameters("batchnorm", shape, first)
    statistics = torch.zeros(9, dtype=torch.float64), torch.ones(9, dtype=torch.float64)
    offset = torch.arange(9, dtype=torch.float64).reshape(1, 9, 1, 1) * 0.25
    for step in range(3):
        x = (tensor(first + 10 + step, (batch, *shape)).detach() + offset).float().double().requires_grad_()
        for v in p.values():
            v.grad = None
        y = apply("batchnorm", x, p, statistics)
        dy = tensor(first + 20 + step, y.shape).detach()
        y.backward(dy)
        # Magnitudes of the terms of y = scale x + shift and diff_src = a diff_dst + b src + c.
        inverse = 1 / torch.sqrt(x.var((0, 2, 3), unbiased=False) + 1e-5).detach()
        mean = x.mean((0, 2, 3)).abs().detach()
        largest, scale = x.abs().max().detach(), (p["gamma"].abs() * inverse).detach()
        count = batch * 30
        length = shape[2] + 8
        emit(f"batchnorm{step}/dst", y, length, (scale * (largest + mean) + p["beta"].abs()).max())
        b = scale * inverse * p["gamma"].grad.abs() / count
        emit(f"batchnorm{step}/diff_src", x.grad, length,
             (scale * (1 + p["beta"].grad.abs() / count) + b * (largest + mean)).max())
        # Rows are summed in float, and the rows' sums, which err independently, in double; src - mean errs with mean.
        rows = math.sqrt(batch * shape[1]) * shape[2]
        emit(f"batchnorm{step}/gamma", p["gamma"].grad, length,
             (inverse * (rows * (largest + mean) + p["beta"].grad.abs() * mean)).max())
        emit(f"batchnorm{step}/beta", p["beta"].grad, length, rows)
        emit(f"batchnorm{step}/running_mean", statistics[0], length, largest)
        emit(f"batchnorm{step}/running_variance", statistics[1], length, largest**2)
    y = apply("batchnorm", tensor(first + 30, (batch, *shape)), p, statistics, training=False)
    inverse = 1 / torch.sqrt(statistics[1] + 1e-5)
    emit("batchnorm/inference", y, length, ((1 + statistics[0].abs()) * p["gamma"].abs() * inverse).max() + 1)


def network_figures():
    first, shape = 8000, NETWORK_SHAPE
    layers, statistics = [], []
    x = tensor(first, (NETWORK_BATCH, *shape), 1.5, 0.2).detach()
    probe = x
    for i, line in enumerate(NETWORK):
        layers.append(parameters(line, tuple(probe.shape[1:]), first + 10 + 2 * i))
        channels = probe.shape[1]
        statistics.append((torch.zeros(channels, dtype=torch.float64), torch.ones(channels, dtype=torch.float64)))
        probe = apply(line, probe, layers[-1], [s.clone() for s in statistics[-1]])
    target = tensor(first + 1, (NETWORK_BATCH, 3)).detach()
    weights = [p["weight"] for p in layers if "weight" in p]
    others = [v for p in layers for k, v in p.items() if k != "weight"]
    optimizer = torch.optim.SGD([{"params": weights, "weight_decay": WEIGHT_DECAY}, {"params": others}],
                                lr=LEARNING_RATE, momentum=MOMENTUM)

    def forward(x, training):
        for line, p, s in zip(NETWORK, layers, statistics):
            x = apply(line, x, p, s, training)
        return x.flatten(1)

    # The longest sums of a forward and a backward pass, layer after layer, as many times as there are steps.
    length = 0
    for p in layers:
        if "weight" in p:
            length += p["weight"].shape[1:].numel() + p["weight"].shape[0] * p["weight"].shape[2:].numel()
    losses = []
    for step in range(STEPS):
        optimizer.zero_grad()
        loss = F.mse_loss(forward(x, True), target)
        loss.backward()
        losses.append(loss.detach())
        if step == 0:
            largest = max(v.grad.abs().max() for p in layers for v in p.values())
            for i, p in enumerate(layers):
                for key, v in p.items():
                    emit(f"network/gradient{i}.{key}", v.grad, length, largest)
        optimizer.step()
    emit("network/losses", torch.stack(losses), STEPS * length, max(losses))
    for i, p in enumerate(layers):
        for key, v in p.items():
            emit(f"network/{i}.{key}", v, STEPS * length, v.abs().max())
        if NETWORK[i] == "batchnorm":
            for key, s in zip(("running_mean", "running_variance"), statistics[i]):
                emit(f"network/{i}.{key}", s, STEPS * length, s.abs().max())
    y = forward(tensor(first + 2, (NETWORK_BATCH, *shape), 1.5, 0.2).detach(), False)
    emit("network/inference", y, STEPS * length, y.abs().max())


print(f"// Made by tests/nn/torch_figures.py with PyTorch {torch.__version__}: do not edit.")
for case in LAYERS:
    layer_figures(*case)
batchnorm_figures()
network_figures()
