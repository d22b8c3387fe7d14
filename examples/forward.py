"""A model's estimates computed with NumPy, from its file and the images that its network sees.

    decid image data.npz --model model.safetensors -o images.npz
    python3 examples/forward.py model.safetensors images.npz      prints a line a trial: the parameters in SI units

The estimates are for the model's own body; those of another one are times its m g h (docs/reference/posture-model.md).
"""
import json
import math
import sys

import model_file
import numpy
from numpy.lib.stride_tricks import sliding_window_view

EPSILON = 1e-5  # of batchnorm and statspool
MIXTURE_LIMIT = 7.0  # of the logarithms of A's diagonal


def pair(text):
    """'3x1' as (3, 1)."""
    return tuple(int(number) for number in text.split("x"))


def windows(x, size, stride, dilation=(1, 1)):
    """x: (trials, channels, rows, columns); the windows' values are the last two axes of six."""
    reach = [(extent - 1) * step + 1 for extent, step in zip(size, dilation)]
    return sliding_window_view(x, reach, axis=(2, 3))[:, :, :: stride[0], :: stride[1], :: dilation[0], :: dilation[1]]


def padded(x, options, value=0.0):
    rows, columns = pair(options.get("pad", "0x0"))
    return numpy.pad(x, ((0, 0), (0, 0), (rows, rows), (columns, columns)), constant_values=value)


def layer(x, words, tensor):
    """One line of the architecture. tensor(name): of this line."""
    kind, options = words[0], dict(zip(words[2::2], words[3::2]))
    if kind == "conv":
        options = dict(zip(words[3::2], words[4::2]))
        weight, groups = tensor("weight"), int(options.get("groups", "1"))
        seen = windows(padded(x, options), weight.shape[2:], pair(options["stride"]), pair(options.get("dilation", "1x1")))
        parts = [numpy.einsum("ncijkl,ockl->noij", *each, optimize=True)
                 for each in zip(numpy.split(seen, groups, axis=1), numpy.split(weight, groups))]
        return numpy.concatenate(parts, axis=1) + tensor("bias")[:, None, None]
    if kind == "batchnorm":
        scale = tensor("gamma") / numpy.sqrt(tensor("running_variance") + EPSILON)
        shift = tensor("beta") - tensor("running_mean") * scale
        return x * scale[:, None, None] + shift[:, None, None]
    if kind == "layernorm":
        off = x - x.mean(axis=(1, 2, 3), keepdims=True)
        normal = off / numpy.sqrt((off**2).mean(axis=(1, 2, 3), keepdims=True) + EPSILON)
        return normal * tensor("gamma")[:, None, None] + tensor("beta")[:, None, None]
    if kind == "relu":
        return numpy.maximum(x, 0.0)
    if kind == "leakyrelu":
        return numpy.where(x > 0, x, float(words[1]) * x)
    if kind == "gelu":
        return x * 0.5 * (1 + numpy.vectorize(math.erf)(x / math.sqrt(2)))
    if kind == "tanh":
        return numpy.tanh(x)
    if kind == "sigmoid":
        return 1 / (1 + numpy.exp(-x))
    if kind == "dropout":
        return x
    if kind == "maxpool":
        return windows(padded(x, options, -numpy.inf), pair(words[1]), pair(options["stride"])).max(axis=(4, 5))
    if kind == "avgpool":
        return windows(padded(x, options), pair(words[1]), pair(options["stride"])).mean(axis=(4, 5))
    if kind == "globalavgpool":
        return x.mean(axis=(2, 3), keepdims=True)
    if kind == "statspool":
        mean, variance = x.mean(axis=(2, 3), keepdims=True), x.var(axis=(2, 3), keepdims=True)
        return numpy.concatenate([mean, numpy.sqrt(variance + EPSILON)], axis=1)
    if kind == "fc":
        return (x.reshape(len(x), -1) @ tensor("weight").T + tensor("bias"))[:, :, None, None]
    raise ValueError("no layer is called " + kind)


def network(metadata, tensors, images):
    """The outputs, (trials, outputs), in double precision."""
    x, kept = images.astype(float), []  # what residuals and concats that are open began with
    for number, line in enumerate(metadata["architecture"].split("\n")):
        words = line.split()
        if words[0] in ("residual", "concat"):
            kept.append((words[0], x))
        elif words[0] == "}":
            kind, begun = kept.pop()
            x = begun + x if kind == "residual" else numpy.concatenate([begun, x], axis=1)
        else:
            x = layer(x, words, lambda name: tensors[f"layers.{number}.{name}"].astype(float))
    return x.reshape(len(x), -1)


def mixture_mean(outputs, components, parameters):
    """The mean share of each parameter's range: that of Phi(x), x a mixture of Gaussians (identify/network/mixture.hpp)."""
    parts = outputs.reshape(components, -1)
    weights = numpy.exp(parts[:, 0] - parts[:, 0].max())
    shares = numpy.zeros(parameters)
    for weight, part in zip(weights / weights.sum(), parts):
        centre, log_diagonal, below = numpy.split(part[1:], [parameters, 2 * parameters])
        a = numpy.diag(numpy.exp(numpy.clip(log_diagonal, -MIXTURE_LIMIT, MIXTURE_LIMIT)))
        a[numpy.tril_indices(parameters, -1)] = below
        variance = (numpy.linalg.inv(a) ** 2).sum(axis=1)  # A^t A is the inverse of the covariance
        shares += weight * numpy.array([0.5 * math.erfc(-z / math.sqrt(2)) for z in centre / numpy.sqrt(1 + variance)])
    return shares


def estimates(metadata, outputs):
    """The parameters in SI units, (trials, parameters)."""
    targets = json.loads(metadata["targets"])
    mean, deviation = numpy.array(targets["mean"]), numpy.array(targets["deviation"])
    head = metadata.get("head", "point").split()
    if head[0] == "mixture":
        shares = numpy.array([mixture_mean(each, int(head[1]), len(mean)) for each in outputs])
        outputs = (shares - 0.5) * math.sqrt(12)
    return mean + deviation * outputs


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    metadata, tensors = model_file.read(sys.argv[1])
    seen = numpy.load(sys.argv[2])
    print(",".join(json.loads(seen["decid.json"].item())["parameters"]))
    for line in estimates(metadata, network(metadata, tensors, seen["images"])):
        print(",".join(f"{value:.9g}" for value in line))
