#!/usr/bin/python3
"""PyTorch's training step of the networks of bench/nn/networks.hpp: SGD with momentum, float32, channels_last.

usage: training.py NETWORK BATCH THREADS SECONDS; prints the version and samples/s of the best step. One thread: CPU
time; more: wall time. Debian: python3-torch.
"""
import sys
import time

import torch
from torch import nn


def block(source, filters, pool):
    layers = [nn.Conv2d(source, filters, 3, padding=1), nn.BatchNorm2d(filters), nn.ReLU(inplace=True)]
    return layers + ([pool(2)] if pool else [])


NETWORKS = {
    "NetA": lambda: nn.Sequential(
        *block(2, 8, nn.AvgPool2d), *block(8, 16, nn.AvgPool2d), *block(16, 32, None), *block(32, 32, None),
        nn.Flatten(), nn.Linear(32 * 27 * 27, 7)),
    "NetB": lambda: nn.Sequential(
        *block(2, 64, nn.MaxPool2d), *block(64, 64, nn.MaxPool2d), *block(64, 128, nn.MaxPool2d),
        *block(128, 128, None), nn.AdaptiveAvgPool2d(1), nn.Flatten(), nn.Linear(128, 7)),
}


def main(name, batch, threads, seconds):
    torch.set_num_threads(threads)
    torch.manual_seed(1)
    network = NETWORKS[name]().to(memory_format=torch.channels_last)
    images = torch.randn(batch, 2, 110, 110).to(memory_format=torch.channels_last)
    targets = torch.randn(batch, 7)
    optimizer = torch.optim.SGD(network.parameters(), lr=1e-3, momentum=0.9, weight_decay=1e-4)

    def step():
        optimizer.zero_grad(set_to_none=True)
        nn.functional.mse_loss(network(images), targets).backward()
        optimizer.step()

    clock = time.process_time if threads == 1 else time.perf_counter
    for _ in range(2):
        step()
    times = []
    while sum(times) < seconds or len(times) < 3:
        start = clock()
        step()
        times.append(clock() - start)
    print(torch.__version__, batch / min(times))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]))
