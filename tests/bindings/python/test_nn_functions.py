"""decid.nn: derivatives by the inputs; losses, samples and optimisers of Python, what they raise; the page's examples."""
import contextlib
import gc
import io
import os
import re
import sys
import tempfile
import threading
import unittest
import weakref
from functools import partial
from pathlib import Path

import numpy as np

import decid
import decid.nn as nn

ROOT = Path(os.environ["DECID_SOURCE_DIR"])
sys.path.insert(0, str(ROOT / "examples"))
import forward  # noqa: E402
import model_file  # noqa: E402

TEXT = "conv 4 3x3 pad 1; batchnorm; relu; maxpool 2; fc 3"
EPSILON = np.finfo(np.float32).eps


def data(count=60):
    labels = np.arange(count) % 3
    images = np.random.default_rng(1).normal(size=(count, 1, 6, 6)).astype(np.float32)
    for image, label in zip(images, labels):
        image[0, :, 2 * label : 2 * label + 2] += 3
    return images, labels, np.eye(3, dtype=np.float32)[labels]


def fitted(*samples, **options):
    net = nn.Network((1, 6, 6), TEXT)
    log = net.fit(*samples, **{"epochs": 2, "batch": 20, "learning_rate": 0.01, **options})
    return net, log


def parameters(net):
    """Copies of what a step changes."""
    return {name: tensor.copy() for name, tensor in net.tensors.items() if "running" not in name}


def squared_error(outputs, targets):
    """The built-in loss, operation by operation."""
    error = outputs - targets
    return (error**2).sum(axis=1) / error.shape[1], 2 * error / error.shape[1] / len(error)


class Noisy:
    """Samples of arrays, with noise in training. Notes the epochs, and the noise by epoch and sample."""

    def __init__(self, images, targets, noise=0.1):
        self.images, self.targets, self.noise = images, targets, noise
        self.epochs, self.drawn = [], {}

    def __call__(self, samples, epoch, random, inputs, targets):
        inputs[:] = self.images[samples]
        targets[:] = self.targets[samples]
        self.epochs.append((epoch, random is not None))
        if random is not None and self.noise:
            added = np.hstack([random.normal(30), random.uniform(6)])
            self.drawn.update({(epoch, int(sample)): tuple(row) for sample, row in zip(samples, added)})
            inputs += self.noise * added.reshape(inputs.shape)


class InputGradients(unittest.TestCase):
    def test_differences_of_every_layer(self):
        """Outputs, and their differences, of examples/forward.py in double; decid errs by roundings of float, some ten layers forward and back."""
        random = np.random.default_rng(2)
        inputs = random.normal(size=(3, 4, 9, 8)).astype(np.float32)
        for text in (
                "conv 6 3x3 pad 1 groups 2; leakyrelu 0.2; conv 8 3x2 pad 2x1 dilation 2x3; tanh; maxpool 3 stride 2 pad 1; fc 5",
                "conv 6 3x3 stride 2x1 pad 1; layernorm; gelu; dropout 0.5; avgpool 3 stride 2 pad 1; sigmoid; statspool",
                "conv 4 1x1; residual { conv 4 3x3 pad 1; batchnorm; relu; concat { conv 2 1x1 }; conv 4 1x1 }; relu; "
                "maxpool 2; globalavgpool; fc 6; batchnorm; layernorm; residual { tanh }; concat { fc 3 }; fc 4"):
            net = nn.Network((4, 9, 8), text)
            net.initialise(3)
            for name, tensor in net.tensors.items():
                if name.partition(".running_")[1] or name.endswith(("gamma", "beta")):
                    tensor[:] = random.uniform(0.5, 1.5, tensor.shape)
            with tempfile.TemporaryDirectory() as folder:
                net.save(Path(folder) / "net.safetensors")
                file = model_file.read(str(Path(folder) / "net.safetensors"))
            outputs, expected = net.predict(inputs), forward.network(*file, inputs)
            np.testing.assert_allclose(outputs.reshape(3, -1), expected, rtol=0, atol=2e-6 * np.abs(expected).max())
            by_output = random.normal(size=outputs.shape).astype(np.float32)
            found = net.input_gradient(inputs, by_output)
            self.assertEqual(found.shape, inputs.shape)
            step, places = 1e-6, random.choice(inputs[0].size, 40, replace=False)
            for sample in range(3):
                moved = np.repeat(inputs[sample].astype(float).reshape(1, -1), 80, axis=0)
                moved[range(40), places] += step
                moved[range(40, 80), places] -= step
                sums = forward.network(*file, moved.reshape(80, 4, 9, 8)) @ by_output[sample].ravel().astype(float)
                expected = (sums[:40] - sums[40:]) / (2 * step)
                np.testing.assert_allclose(found[sample].ravel()[places], expected, rtol=0, atol=4e-6 * np.abs(found).max())

    def test_shapes_and_single_samples(self):
        net = nn.Network((2, 3, 1), "fc 4; batchnorm; tanh; fc 3")
        net.initialise(1)
        inputs = np.linspace(-1, 1, 24).reshape(4, 2, 3)
        second = net.input_gradient(inputs, [0, 1, 0])
        self.assertEqual(second.shape, inputs.shape)
        np.testing.assert_array_equal(second, net.input_gradient(inputs, np.tile([0, 1, 0], (4, 1))))
        np.testing.assert_array_equal(second[2:3], net.input_gradient(inputs[2:3], [0, 1, 0]))
        np.testing.assert_array_equal(second.reshape(4, 6), net.input_gradient(inputs.reshape(4, 6), [0, 1, 0]))
        before = net.weights_sha256
        for call in (lambda: net.input_gradient(inputs, [0, 1]), lambda: net.input_gradient(inputs, np.ones((3, 3))),
                     lambda: net.input_gradient(inputs[:, :, :2], [0, 1, 0]), lambda: net.input_gradient(1, [0, 1, 0])):
            with self.assertRaises(decid.Error) as raised:
                call()
            self.assertEqual(raised.exception.code, "size_mismatch")
        self.assertEqual(net.weights_sha256, before)


class Losses(unittest.TestCase):
    def test_the_bits_of_the_built_in_one(self):
        images, _, targets = data()
        net, log = fitted(images, targets)
        for threads in (1, 3):
            decid.set_threads(threads)
            own, own_log = fitted(images, targets, loss=squared_error)
            self.assertEqual(own.weights_sha256, net.weights_sha256)
            self.assertEqual(own_log, log)

    def test_the_mean_and_other_roundings(self):
        images, _, targets = data()

        def mean_error(outputs, targets):
            error = outputs - targets
            return (error**2).mean(), 2 / error.size * error

        options = {"optimiser": "sgd", "learning_rate": 0.03}
        net, log = fitted(images, targets, **options)
        own, own_log = fitted(images, targets, loss=mean_error, **options)
        # A derivative rounds to float twice, with different results for one in 2^29. Each step may then err by epsilon.
        for name, tensor in own.tensors.items():
            np.testing.assert_allclose(tensor, net.tensors[name], rtol=0, atol=6 * EPSILON * np.abs(tensor).max())
        for one, other in zip(own_log.epochs, log.epochs):
            self.assertAlmostEqual(one.training_loss / other.training_loss, 1, delta=6 * EPSILON)

    def test_shapes(self):
        images, labels, _ = data()
        seen = []

        def loss(outputs, targets):
            seen.append((outputs.dtype, outputs.shape[1:], targets.shape[1:], len(outputs) == len(targets)))
            outputs[:], value = 0, np.zeros(len(outputs))  # arrays of its own
            return value, outputs

        fitted(images, labels, loss=loss)
        net = nn.Network((1, 6, 6), "conv 2 3x3")
        net.fit(images, np.zeros((60, 5, 7)), loss=loss, epochs=1)
        self.assertEqual(set(seen), {(np.dtype(float), (3,), (), True), (np.dtype(float), (2, 4, 4), (5, 7), True)})


class SamplesOfFunctions(unittest.TestCase):
    def test_the_bits_of_arrays(self):
        images, labels, targets = data()
        plain = fitted(images, labels, loss="cross-entropy")
        own = fitted(nn.Samples(60, Noisy(images, labels, 0)), loss="cross-entropy")
        self.assertEqual((own[0].weights_sha256, own[1]), (plain[0].weights_sha256, plain[1]))
        self.assertEqual(fitted(nn.Samples(60, Noisy(images, targets, 0)))[0].weights_sha256, fitted(images, targets)[0].weights_sha256)
        validated = fitted(images, targets, validation=nn.Samples(60, Noisy(images, targets, 0)))
        self.assertEqual(validated[1], fitted(images, targets, validation=(images, targets))[1])

    def test_augmentation_is_the_same_for_any_threads(self):
        images, labels, _ = data()
        makers, hashes = [], set()
        for threads in (1, 2, 3):
            decid.set_threads(threads)
            makers.append(Noisy(images, labels))
            hashes.add(fitted(nn.Samples(60, makers[-1]), loss="cross-entropy")[0].weights_sha256)
        self.assertEqual(len(hashes), 1)
        self.assertNotEqual(hashes, {fitted(images, labels, loss="cross-entropy")[0].weights_sha256})
        maker = makers[0]
        # 54 samples in 3 batches, then 6 for validation.
        self.assertEqual(maker.epochs, ([(1, True)] * 3 + [(1, False)]) + [(2, True)] * 3 + [(2, False)])
        self.assertEqual(len(set(maker.drawn.values())), 2 * 54)
        other = Noisy(images, labels)
        fitted(nn.Samples(60, other), loss="cross-entropy", batch=7)
        self.assertEqual(other.drawn, maker.drawn)
        for one in makers[1:]:
            self.assertEqual((one.epochs, one.drawn), (maker.epochs, maker.drawn))

    def test_target_shape(self):
        images, _, _ = data()
        shapes = set()

        def load(samples, epoch, random, inputs, targets):
            inputs[:] = images[samples]
            targets[:] = 1
            shapes.add(targets.shape[1:])

        def loss(outputs, targets):
            shapes.add(targets.shape[1:])
            return 0, np.zeros_like(outputs)

        fitted(nn.Samples(60, load, (2, 5)), loss=loss)
        self.assertEqual(shapes, {(2, 5)})
        shapes.clear()
        fitted(nn.Samples(60, load), loss=loss)
        nn.Network((1, 6, 6), "conv 2 3x3").fit(nn.Samples(60, load), epochs=1)
        self.assertEqual(shapes, {(3,), (2, 4, 4)})


class Optimisers(unittest.TestCase):
    @staticmethod
    def nesterov(value, gradient, learning_rate, step, velocity):
        velocity *= 0.9
        velocity += gradient
        value -= np.float32(learning_rate) * (gradient + np.float32(0.9) * velocity)

    def test_the_bits_of_the_built_in_one(self):
        images, labels, _ = data()
        options = {"loss": "cross-entropy", "frozen_lines": 1, "clip_norm": 0.5}
        net, _ = fitted(images, labels, optimiser="nesterov weight_decay 0", **options)
        for threads in (1, 3):
            decid.set_threads(threads)
            own, _ = fitted(images, labels, optimiser=nn.Optimiser(self.nesterov, memory=1), **options)
            self.assertEqual(own.weights_sha256, net.weights_sha256)

    def test_arguments(self):
        images, labels, _ = data()
        seen = []

        def update(value, gradient, learning_rate, step):
            seen.append((value.shape, gradient.shape, learning_rate, step))
            gradient[:] = 0  # an array of its own

        net, log = fitted(images, labels, loss="cross-entropy", optimiser=nn.Optimiser(update))
        shapes = [tensor.shape for tensor in parameters(net).values()]
        self.assertEqual([each[:2] for each in seen], 6 * [(shape, shape) for shape in shapes])
        self.assertEqual([each[3] for each in seen], [step for step in range(1, 7) for _ in shapes])
        self.assertEqual(seen[-1][2], log.epochs[-1].learning_rate)
        untouched = nn.Network((1, 6, 6), TEXT)
        untouched.initialise(1)
        for name, tensor in parameters(untouched).items():
            np.testing.assert_array_equal(net.tensors[name], tensor)

    def test_a_checkpoint_has_its_memory(self):
        images, labels, _ = data()

        class Stop(Exception):
            pass

        def stop(epoch):
            raise Stop

        def fit(**options):
            return fitted(images, labels, loss="cross-entropy", optimiser=nn.Optimiser(self.nesterov, 1), **options)[0].weights_sha256

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "checkpoint"
            with self.assertRaises(Stop):
                fit(checkpoint=path, callback=stop)
            self.assertEqual(fit(checkpoint=path), fit())
            with self.assertRaises(decid.Error) as raised:
                fitted(images, labels, loss="cross-entropy", optimiser=nn.Optimiser(lambda *_: None, 1), checkpoint=path)
            self.assertEqual(raised.exception.code, "file_differs")

    def test_a_checkpoint_has_the_numbers_of_a_partial(self):
        images, _, targets = data()

        def scaled(scale, outputs, targets, *, power=2, weights=None):
            value, gradient = squared_error(outputs, targets)
            return scale * value, scale * gradient

        def fit(loss, path):
            return fitted(images, targets, loss=loss, checkpoint=path)[0].weights_sha256

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "checkpoint"
            begun = fit(partial(scaled, 2.0, weights=np.ones(3)), path)
            self.assertEqual(fit(partial(scaled, np.float64(2), weights=np.ones(3)), path), begun)
            for other in (partial(scaled, 3.0, weights=np.ones(3)), partial(scaled, 2.0, power=3), partial(squared_error)):
                with self.assertRaises(decid.Error) as raised:
                    fit(other, path)
                self.assertEqual(raised.exception.code, "file_differs")


class Exceptions(unittest.TestCase):
    class Stop(BaseException):
        """No Exception, as KeyboardInterrupt is none."""

    def fit(self, net, which, raised, before):
        """Fits with a function of each kind, of which one raises after 4 steps: those of epoch 1, and one. before: gets the
        parameters after these."""
        images, _, targets = data()
        maker, steps = Noisy(images, targets, 0), []

        def load(samples, epoch, random, inputs, targets):
            maker(samples, epoch, random, inputs, targets)
            if random is not None:
                steps.append(epoch)
            if len(steps) == 5 and not before:
                before.update(parameters(net))
            if len(steps) == 5 and which == "samples":
                raise raised

        def loss(outputs, targets):
            if len(steps) == 5 and which == "loss":
                raise raised
            return squared_error(outputs, targets)

        def update(value, gradient, learning_rate, step):
            value -= learning_rate * gradient
            if step == 5 and which == "optimiser" and value.ndim == 2:  # the last parameter but one
                raise raised

        net.fit(nn.Samples(60, load), loss=loss, optimiser=nn.Optimiser(update), epochs=2, batch=20, average=0.9, patience=2)

    def test_arrive_and_leave_the_last_step(self):
        decid.set_threads(3)
        images, _, targets = data()
        for which in ("samples", "loss", "optimiser"):
            for kind in (self.Stop, KeyboardInterrupt, ZeroDivisionError, decid.Error):
                with self.subTest(which=which, kind=kind):
                    net, raised, before = nn.Network((1, 6, 6), TEXT), kind(), {}
                    with self.assertRaises(kind) as caught:
                        self.fit(net, which, raised, before)
                    self.assertIs(caught.exception, raised)
                    self.assertEqual(len(before), 6)
                    for name, tensor in before.items():
                        np.testing.assert_array_equal(net.tensors[name], tensor)
                    net.predict(images)
                    net.fit(images, targets, epochs=1)

    def test_nothing_stays(self):
        class Failed(Exception):
            pass

        class Function:
            def __call__(self, outputs, targets):
                raise Failed

        images, _, targets = data()
        loss, error = Function(), None
        net = nn.Network((1, 6, 6), TEXT)
        try:
            net.fit(images, targets, loss=loss)
        except Failed as raised:
            error = weakref.ref(raised)
        left = [weakref.ref(loss), weakref.ref(net), error]
        del loss, net
        gc.collect()
        self.assertEqual([one() for one in left], [None] * 3)


class Guards(unittest.TestCase):
    def test_functions_may_read_the_network_and_fit_others(self):
        images, _, targets = data()
        decid.set_threads(3)
        expected = fitted(images, targets)[0].weights_sha256
        net, errors = nn.Network((1, 6, 6), TEXT), []

        def refused(call):
            try:
                call()
            except decid.Error as error:
                errors.append(error.code)

        def use():
            net.predict(images)
            net.input_gradient(images, [1, 0, 0])
            self.assertEqual(fitted(images, targets)[0].weights_sha256, expected)
            refused(lambda: net.fit(images, targets))
            thread = threading.Thread(target=refused, args=(lambda: net.input_gradient(images, [1, 0, 0]),))
            thread.start()
            thread.join()

        def load(samples, epoch, random, inputs, targets_):
            inputs[:], targets_[:] = images[samples], targets[samples]
            use()

        def loss(outputs, targets):
            use()
            return squared_error(outputs, targets)

        def update(value, gradient, learning_rate, step):
            value -= learning_rate * gradient
            use()

        net.fit(nn.Samples(60, load), loss=loss, optimiser=nn.Optimiser(update), epochs=1, batch=60, validation=0)
        self.assertEqual(errors, ["not_supported"] * 2 * (1 + 1 + 6))

    def test_refusals(self):
        images, _, targets = data()
        maker, net = Noisy(images, targets, 0), nn.Network((1, 6, 6), TEXT)

        def unwritten(samples, epoch, random, inputs, targets):
            targets[:], inputs[1:] = 0, 0

        def ones(samples, epoch, random, inputs, targets):
            targets[:], inputs[:] = 1, 1

        def resized(samples, epoch, random, inputs, targets):
            inputs.resize(7, refcheck=False)

        def resized_value(value, *_):
            value.resize(1, refcheck=False)

        def returning(value, gradient, learning_rate, step):  # as of PyTorch's or JAX's functions
            return value - learning_rate * gradient

        for code, where, options in (
                ("setting_malformed", "loss", {"loss": 3}),
                ("setting_malformed", "loss", {"loss": lambda outputs, targets: 0}),
                ("size_mismatch", "loss", {"loss": lambda outputs, targets: (0, outputs[:1])}),
                ("size_mismatch", "loss", {"loss": lambda outputs, targets: (outputs, outputs)}),
                ("value_invalid", "loss", {"loss": lambda outputs, targets: ("a", outputs)}),
                ("diverged", "fit", {"loss": lambda outputs, targets: (np.nan, outputs)}),
                ("setting_malformed", "optimiser", {"optimiser": lambda *_: None}),
                ("setting_malformed", "optimiser", {"optimiser": nn.Optimiser("sgd")}),
                ("setting_out_of_range", "memory", {"optimiser": nn.Optimiser(print, -1)}),
                ("size_mismatch", "optimiser", {"optimiser": nn.Optimiser(resized_value)}),
                ("setting_malformed", "optimiser", {"optimiser": nn.Optimiser(returning)}),
                ("setting_malformed", "samples", {"samples": nn.Samples(60, None)}),
                ("setting_out_of_range", "count", {"samples": nn.Samples(0, maker)}),
                ("value_invalid", "samples", {"samples": nn.Samples(60, unwritten)}),
                ("size_mismatch", "samples' inputs", {"samples": nn.Samples(60, resized)}),
                ("size_mismatch", "samples' targets", {"samples": nn.Samples(60, ones, (2, 3))}),
                ("setting_conflict", "targets", {"samples": nn.Samples(60, maker), "targets": targets}),
                ("size_mismatch", "targets", {"targets": None})):
            with self.subTest(code=code, where=where), self.assertRaises(decid.Error) as raised:
                given = dict(options)
                samples = given.pop("samples", images)
                net.fit(samples, given.pop("targets", None if isinstance(samples, nn.Samples) else targets), **given)
            self.assertEqual((raised.exception.code, raised.exception.where), (code, where))
        for name, tensor in parameters(net).items():
            self.assertTrue(np.isfinite(tensor).all(), name)


class Page(unittest.TestCase):
    def test_examples_run(self):
        """The blocks of docs/reference/python-nn.md, one after the other."""
        blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / "docs/reference/python-nn.md").read_text(encoding="utf-8"), re.M | re.S)
        self.assertGreater(len(blocks), 4)
        names, here = {}, os.getcwd()
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
            os.chdir(folder)
            try:
                for block in blocks:
                    exec(compile(block, "python-nn.md", "exec"), names)
            finally:
                os.chdir(here)
        self.assertEqual(names["gradients"].shape, (300, 1, 6, 6))
        self.assertGreater(names["net"].accuracy(names["images"], names["labels"]), 0.9)


if __name__ == "__main__":
    unittest.main()
