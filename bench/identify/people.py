#!/usr/bin/python3
"""How much do several recordings of a person tell? Errors of decid identify and decid fit, averaged over recordings.

    PYTHONPATH=build/release/bindings/python /usr/bin/python3 bench/identify/people.py [--people 14] [--recordings 3] [--seed 94] [--no-fits]

Each person has the parameters of a uniform draw from their ranges; each recording has a noise of its own, a body that has stood for
10 s, 0.02 degrees of white noise, an unknown start and gain. The error of the mean over the first 1, 2, ... recordings is squared, over
the variance of the ranges. A fit takes some 10 s of a core.
"""
import argparse
import json
import pathlib
import tempfile

import numpy as np

import decid

PROTOCOL = {"name": "people", "standing_s": 10, "sensor_noise_deg": 0.02,
            "recording": {"start_s": {"share": 1, "size": [0, 0.1]}, "gain": {"share": 1, "size": [0, 0.104]}}}


def answers(sway, rate, seed, with_fit, names):
    """The values of both commands, in the order of `names`."""
    found = {"identify": decid.identify(sway, rate, "rad")}
    if with_fit:
        found["fit"] = decid.fit(sway, rate, "rad", seed=seed)
    return {command: np.array([result.parameters[name].value for name in names]) for command, result in found.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--people", type=int, default=14)
    parser.add_argument("--recordings", type=int, default=3)
    parser.add_argument("--seed", type=int, default=94)
    parser.add_argument("--no-fits", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "people.json"
        path.write_text(json.dumps(PROTOCOL))
        protocol = decid.Protocol(path)
    low, high = (np.array([getattr(info, end) for info in protocol.parameters]) for end in ("low", "high"))
    names = [info.name for info in protocol.parameters]
    random = np.random.default_rng(options.seed)
    squares = {}
    people = number = 0
    while people < options.people:
        number += 1
        truth = random.uniform(low, high)
        alike = {name: np.full(options.recordings, value) for name, value in zip(names, truth)}
        trials = decid.simulate(protocol, seed=1000 * options.seed + 100 * number, allow_falls=True, **alike)
        if not trials.valid.all():
            continue
        people += 1
        sums = {}
        for k in range(options.recordings):
            for command, values in answers(trials.sway[k], trials.rate, number, not options.no_fits, names).items():
                sums[command] = sums.get(command, 0.0) + values
                error = np.mean((sums[command] / (k + 1) - truth) ** 2 / ((high - low) ** 2 / 12))
                squares.setdefault(command, np.zeros(options.recordings))[k] += error
        print(f"{people} people:", ", ".join(f"{command} " + " ".join(f"{value / people:.3f}" for value in of_command)
                                             for command, of_command in squares.items()), flush=True)


main()
