"""decid.nn: trains, predicts, saves; the same bits for any threads; what it refuses."""
import copy
import multiprocessing
import os
import pickle
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

import numpy as np

import decid
import decid.nn as nn

TEXT = "conv 4 3x3 pad 1; batchnorm; relu; maxpool 2; fc 3"


def data(count=240):
    random = np.random.default_rng(1)
    labels = np.arange(count) % 3
    images = random.normal(size=(count, 1, 6, 6))
    for image, label in zip(images, labels):
        image[0, :, 2 * label : 2 * label + 2] += 3
    return images, labels


def call_in_child(method):
    images, labels = data(30)
    net = nn.Network((1, 6, 6), TEXT)
    {"fit": lambda: net.fit(images, labels, loss="cross-entropy", epochs=1), "predict": lambda: net.predict(images),
     "accuracy": lambda: net.accuracy(images, labels)}[method]()


class Networks(unittest.TestCase):
    def test_learns_and_predicts(self):
        images, labels = data()
        net, seen = nn.Network((1, 6, 6), TEXT), []
        log = net.fit(images, labels, loss="cross-entropy", epochs=4, batch=20, learning_rate=0.01, callback=seen.append)
        self.assertEqual(seen, log.epochs)
        self.assertEqual(log.kept, 4)
        self.assertLess(log.epochs[-1].training_loss, 0.5 * log.epochs[0].training_loss)
        scores = net.predict(images)
        self.assertEqual(scores.shape, (240, 3))
        self.assertEqual(net.accuracy(images, labels), (scores.argmax(axis=1) == labels).mean())
        self.assertGreater(net.accuracy(images, labels), 0.95)
        decid.set_threads(1)
        other = nn.Network((1, 6, 6), TEXT)
        other.fit(images, labels, loss="cross-entropy", epochs=4, batch=20, learning_rate=0.01)
        self.assertEqual(other.weights_sha256, net.weights_sha256)

    def test_files_and_tensors(self):
        net = nn.Network((2, 5, 4), "conv 3 3x3; tanh; residual { conv 3 3x3 pad 1 }")
        net.initialise(3)
        inputs = np.linspace(-1, 1, 80).reshape(2, 2, 5, 4)
        self.assertEqual(net.predict(inputs).shape, (2, 3, 3, 2))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "net.safetensors"
            net.save(path)
            again = nn.load(path)
            shown = subprocess.run([os.environ["DECID_PROGRAM"], "info", path], check=True, capture_output=True, text=True)
            self.assertIn(net.weights_sha256, shown.stdout)
        self.assertEqual(again.architecture, net.architecture)
        np.testing.assert_array_equal(again.predict(inputs), net.predict(inputs))
        weight = again.tensors["layers.0.weight"]
        self.assertEqual(weight.shape, (3, 2, 3, 3))
        weight[:] = 0
        self.assertNotEqual(again.weights_sha256, net.weights_sha256)
        self.assertIn("(2, 5, 4)", repr(net))

    def test_settings_of_losses_and_optimisers(self):
        images, labels = data(60)

        def fitted(loss, optimiser):
            net = nn.Network((1, 6, 6), "fc 1")
            net.fit(images, labels, loss=loss, optimiser=optimiser, epochs=1, batch=20)
            return net.weights_sha256

        self.assertEqual(fitted("huber", "sgd"), fitted("huber 1", "sgd momentum 0.9"))
        self.assertNotEqual(fitted("huber", "sgd"), fitted("huber 0.1", "sgd"))
        self.assertNotEqual(fitted("huber", "adamw"), fitted("huber", "adamw weight_decay 0.5"))

    def test_checkpoint_and_callbacks(self):
        images, labels = data()

        def fitted(**options):
            net = nn.Network((1, 6, 6), TEXT)
            net.fit(images, labels, loss="cross-entropy", epochs=3, batch=20, validation=(images[:9], labels[:9]), **options)
            return net.weights_sha256

        class Stop(Exception):
            pass

        def stop(epoch):
            if epoch.epoch == 2:
                raise Stop

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "checkpoint"
            with self.assertRaises(Stop):
                fitted(checkpoint=path, callback=stop)
            with self.assertRaises(decid.Error) as raised:  # its weights are not those that the fit will keep
                nn.load(path)
            self.assertEqual(raised.exception.code, "file_unsupported")
            self.assertEqual(fitted(checkpoint=path), fitted())

    def test_tensors_stay_views_in_a_fit_that_goes_on(self):
        images, labels = data(60)
        net = nn.Network((1, 6, 6), TEXT)
        views = net.tensors
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(2):
                net.fit(images, labels, loss="cross-entropy", epochs=1, batch=20, average=0.9, patience=1,
                        checkpoint=Path(folder) / "checkpoint")
        for name, tensor in net.tensors.items():
            self.assertTrue(np.shares_memory(views[name], tensor), name)

    def test_a_network_in_fit_is_not_used_elsewhere(self):
        images, labels = data(60)
        net, errors, scores = nn.Network((1, 6, 6), TEXT), [], []
        calls = (lambda: net.predict(images), lambda: net.accuracy(images, labels), lambda: net.weights_sha256,
                 lambda: pickle.dumps(net), lambda: net.initialise(1), lambda: net.fit(images, labels, loss="cross-entropy"))

        def collect(those):
            for call in those:
                try:
                    call()
                except decid.Error as error:
                    errors.append((error.code, error.where))

        def callback(epoch):
            thread = threading.Thread(target=collect, args=(calls,))
            thread.start()
            thread.join()
            collect(calls[4:])
            scores.append(net.predict(images))  # it may read

        net.fit(images, labels, loss="cross-entropy", epochs=1, batch=20, callback=callback)
        self.assertEqual(errors, [("not_supported", "network")] * 8)
        np.testing.assert_array_equal(scores[0], net.predict(images))
        net.initialise(2)
        other = nn.Network((1, 6, 6), TEXT)
        other.fit(images, labels, loss="cross-entropy", epochs=1, batch=20)
        again = nn.Network((1, 6, 6), TEXT)
        again.fit(images, labels, loss="cross-entropy", epochs=1, batch=20, callback=lambda _: other.initialise(1))

    def test_pickle_and_copies(self):
        net = nn.Network((2, 5, 4), "conv 3 3x3; batchnorm; relu; fc 2")
        net.initialise(3)
        for copied in (pickle.loads(pickle.dumps(net)), copy.copy(net), copy.deepcopy(net)):
            self.assertEqual(copied.weights_sha256, net.weights_sha256)
            self.assertEqual(copied.input_shape, net.input_shape)
            copied.initialise(4)
            self.assertNotEqual(copied.weights_sha256, net.weights_sha256)

    def test_tensors_take_values_and_no_arrays(self):
        net = nn.Network((2, 5, 4), "fc 2")
        with self.assertRaises(TypeError):
            net.tensors["layers.0.bias"] = np.ones(2, np.float32)
        net.tensors["layers.0.bias"][:] = [1, 2]
        np.testing.assert_array_equal(net.tensors["layers.0.bias"], [1, 2])
        with self.assertRaises(ValueError):
            net.tensors["layers.0.bias"][:] = [1, 2, 3]

    def test_values_that_would_be_lost_or_are_no_numbers(self):
        images, labels = data(30)
        net = nn.Network((1, 6, 6), TEXT)
        masked = np.ma.masked_array(images, mask=images > 2)
        for code, name, call in (
                ("value_missing", "inputs", lambda: net.predict(masked)),
                ("value_missing", "labels", lambda: net.accuracy(images, np.ma.masked_equal(labels, 1))),
                ("value_missing", "targets", lambda: net.fit(images, np.ma.masked_equal(labels, 1), loss="cross-entropy")),
                ("value_missing", "validation inputs", lambda: net.fit(images, labels, loss="cross-entropy", validation=(masked, labels))),
                ("value_invalid", "inputs", lambda: net.predict(images + 1j)),
                ("value_invalid", "inputs", lambda: net.predict([["a"]])),
                ("value_invalid", "inputs", lambda: net.predict(np.zeros((3, 1, 6, 6), "M8[ms]"))),
                ("value_invalid", "inputs", lambda: net.predict(np.zeros((3, 1, 6, 6), "m8[s]"))),
                ("setting_malformed", "validation", lambda: net.fit(images, labels, loss="cross-entropy", validation=(images,))),
                ("setting_malformed", "schedule", lambda: net.fit(images, labels, loss="cross-entropy", schedule=None)),
                ("setting_malformed", "input_shape", lambda: nn.Network((6, 6), TEXT)),
                ("setting_malformed", "input_shape", lambda: nn.Network(36, TEXT)),
                ("setting_malformed", "input_shape", lambda: nn.Network((1, 6.0, 6), TEXT)),
                ("setting_malformed", "architecture", lambda: nn.Network((1, 6, 6), ["fc 3"])),
                ("setting_malformed", "epochs", lambda: net.fit(images, labels, loss="cross-entropy", epochs=1.5)),
                ("setting_out_of_range", "seed", lambda: net.fit(images, labels, loss="cross-entropy", seed=-1)),
                ("setting_out_of_range", "seed", lambda: net.initialise(-1)),
                ("setting_out_of_range", "fit", lambda: net.fit(images, labels, loss="cross-entropy", learning_rate=0)),
                ("setting_out_of_range", "fit", lambda: net.fit(images, labels, loss="cross-entropy", frozen_lines=6)),
                ("value_invalid", "samples", lambda: net.fit(np.where(images > 2, np.nan, images), labels, loss="cross-entropy"))):
            with self.subTest(name=name), self.assertRaises(decid.Error) as raised:
                call()
            self.assertEqual((raised.exception.code, raised.exception.where), (code, name))

    def test_arguments_that_c_would_cut_or_not_take(self):
        images, labels = data(30)
        net = nn.Network((1, 6, 6), TEXT)
        before = net.weights_sha256

        def fit(**options):
            return lambda: net.fit(images, labels, **{"loss": "cross-entropy", "epochs": 1, **options})

        with tempfile.TemporaryDirectory() as folder:
            cut = folder + "/a\0b"
            for name, call in (
                    ("path", lambda: net.save(cut)), ("path", lambda: net.save(cut.encode())), ("path", lambda: net.save(Path(cut))),
                    ("path", lambda: net.save(None)), ("path", lambda: net.save(folder + "/\ud800")), ("path", lambda: nn.load(cut)),
                    ("path", lambda: nn.load(3.5)), ("checkpoint", fit(checkpoint=cut)), ("checkpoint", fit(checkpoint=None)),
                    ("architecture", lambda: nn.Network((1, 6, 6), "fc 3\0; fc 4")), ("architecture", lambda: nn.Network((1, 6, 6), "fc \udcff")),
                    ("loss", fit(loss="cross-entropy\0")), ("loss", fit(loss="\udcff")), ("loss", fit(loss=3)),
                    ("optimiser", fit(optimiser="adamw\0")), ("optimiser", fit(optimiser="\udcff")), ("schedule", fit(schedule="constant\0")),
                    ("callback", fit(callback=3)), ("callback", fit(callback="print")), ("learning_rate", fit(learning_rate=10**400)),
                    ("learning_rate", fit(learning_rate=10**5000)), ("validation", fit(validation=10**400))):
                with self.subTest(name=name), self.assertRaises(decid.Error) as raised:
                    call()
                self.assertEqual((raised.exception.code, raised.exception.where), ("setting_malformed", name))
            for name, call in (("inputs", lambda: net.predict([[10**400] * 36])), ("targets", lambda: net.fit(images, [10**400] * 30))):
                with self.subTest(name=name), self.assertRaises(decid.Error) as raised:
                    call()
                self.assertEqual((raised.exception.code, raised.exception.where), ("value_invalid", name))
            for epochs in (10**400, 10**5000):
                with self.assertRaises(decid.Error) as raised:
                    fit(epochs=epochs)()
                self.assertEqual((raised.exception.code, raised.exception.where), ("setting_out_of_range", "epochs"))
            self.assertEqual(os.listdir(folder), [])
        self.assertEqual(net.weights_sha256, before)

    def test_weights_set_in_some_layers_need_initialise(self):
        images, labels = data(60)
        copied = np.random.default_rng(1).normal(size=(4, 1, 3, 3))
        text = "conv 4 3; relu; fc 5; relu; fc 3"
        net = nn.Network((1, 6, 6), text)
        net.tensors["layers.0.weight"][:] = copied
        with self.assertRaises(decid.Error) as raised:
            net.fit(images, labels, loss="cross-entropy", epochs=1)
        self.assertEqual((raised.exception.code, raised.exception.where), ("setting_missing", "fit"))
        net.initialise(2)
        net.tensors["layers.0.weight"][:] = copied
        before = net.tensors["layers.2.weight"].copy()
        net.fit(images, labels, loss="cross-entropy", epochs=1)
        self.assertTrue((net.tensors["layers.2.weight"] != before).any())

    def test_a_checkpoint_of_other_arrays_is_refused(self):
        images, labels = data(60)
        with tempfile.TemporaryDirectory() as folder:
            def fit(inputs):
                nn.Network((1, 6, 6), TEXT).fit(inputs, labels, loss="cross-entropy", epochs=1, checkpoint=Path(folder) / "checkpoint")
            fit(images)
            fit(images)
            with self.assertRaises(decid.Error) as raised:
                fit(images + 1)
        self.assertEqual(raised.exception.code, "file_differs")

    def test_axes(self):
        net = nn.Network((2, 3, 1), "fc 3")
        net.initialise(1)
        inputs, targets = np.arange(24.0).reshape(4, 2, 3, 1), np.zeros((4, 3))
        expected = net.predict(inputs)
        for shape in ((4, 2, 3), (4, 6), (4, 1, 2, 3)):
            np.testing.assert_array_equal(net.predict(inputs.reshape(shape)), expected)
        single = nn.Network((1, 1, 1), "fc 2")
        single.initialise(1)
        np.testing.assert_array_equal(single.predict([1.0, 2.0, 3.0]), single.predict([[1.0], [2.0], [3.0]]))
        net.fit(inputs, targets, epochs=1, validation=(inputs, targets))
        net.fit(inputs, [0, 1, 2, 0], loss="cross-entropy", epochs=1, validation=0)
        for call in (lambda: net.predict(inputs.reshape(4, 3, 2)), lambda: net.predict(inputs.reshape(4, 3, 1, 2)),
                     lambda: net.predict(inputs.reshape(8, 3)), lambda: net.predict(inputs.reshape(24)),
                     lambda: net.fit(inputs, targets.T), lambda: net.fit(inputs, targets.ravel()),
                     lambda: net.fit(inputs, targets, validation=(inputs, targets.T)),
                     lambda: net.accuracy(inputs, np.zeros((2, 2))), lambda: net.accuracy(inputs, 0.0)):
            with self.assertRaises(decid.Error) as raised:
                call()
            self.assertEqual(raised.exception.code, "size_mismatch")

    def test_axes_of_targets(self):
        """The order of a plane's axes is not guessed: channels come first."""
        net = nn.Network((1, 4, 5), "conv 2 3x3 pad 1")
        inputs, targets = np.ones((6, 1, 4, 5)), np.arange(240.0).reshape(6, 2, 4, 5)

        def fitted(targets, samples=inputs, **options):
            net.initialise(1)
            net.fit(samples, targets, epochs=1, validation=0, **options)
            return net.weights_sha256

        expected = fitted(targets)
        self.assertEqual(fitted(targets.reshape(6, 40)), expected)
        self.assertEqual(fitted(targets[:, :, None]), expected)
        last = targets.transpose(0, 2, 3, 1)

        def load(samples, epoch, random, inputs, targets):
            inputs[:], targets[:] = 1, last[samples]

        def of_channels_last(outputs, targets):
            error = outputs - targets.transpose(0, 3, 1, 2)
            return (error**2).mean(), 2 * error / error.size

        fitted(last, loss=of_channels_last)
        fitted(None, nn.Samples(6, load, (4, 5, 2)), loss=of_channels_last)
        for where, call in (("targets", lambda: fitted(last)), ("targets", lambda: fitted(last, loss="huber")),
                            ("target_shape", lambda: fitted(None, nn.Samples(6, load, (4, 5, 2)))),
                            ("validation targets", lambda: net.fit(inputs, targets, validation=(inputs, last)))):
            with self.subTest(where=where), self.assertRaises(decid.Error) as raised:
                call()
            self.assertEqual((raised.exception.code, raised.exception.where), ("size_mismatch", where))

    def test_shapes_that_are_no_extents(self):
        net = nn.Network((1, 4, 5), "conv 2 3x3 pad 1")
        for shape in (("4", "5"), (4, None), 5, (2.0, 4)):
            with self.subTest(shape=shape), self.assertRaises(decid.Error) as raised:
                net.fit(nn.Samples(6, lambda *_: None, shape), epochs=1, validation=0)
            self.assertEqual((raised.exception.code, raised.exception.where), ("setting_malformed", "target_shape"))
        flat = nn.Network((1, 4, 5), "fc 6")  # its outputs have no axes to exchange
        flat.fit(np.ones((6, 1, 4, 5)), np.ones((6, 2, 3)), epochs=1, validation=0)

    def test_a_fork_is_refused(self):
        decid.set_threads(2)
        images, _ = data(30)
        nn.Network((1, 6, 6), TEXT).predict(images)
        with multiprocessing.get_context("fork").Pool(1) as pool:
            for method in ("fit", "predict", "accuracy"):
                with self.assertRaisesRegex(decid.Error, "forked"):
                    pool.apply_async(call_in_child, (method,)).get(10)

    def test_refusals(self):
        images, labels = data(30)
        with self.assertRaises(decid.Error) as raised:
            nn.Network((1, 6, 6), "conv 4 3x3; softsign")
        self.assertIn("softsign", raised.exception.where)
        self.assertEqual(raised.exception.code, "setting_malformed")
        net = nn.Network((1, 6, 6), TEXT)
        for call in (lambda: net.predict(images[0, 0, 0]), lambda: net.predict(images[:, :, :5]),
                     lambda: net.fit(images, labels[:7], loss="cross-entropy"), lambda: net.fit(images, labels),
                     lambda: net.fit(images, labels, loss="hinge"), lambda: net.fit(images, labels, optimiser="sgd beta1 0.5"),
                     lambda: nn.load("/nowhere"),
                     lambda: net.fit(images, labels + 1, loss="cross-entropy")):
            self.assertRaises(decid.Error, call)


if __name__ == "__main__":
    unittest.main()
