#!/usr/bin/env python3
"""The figures of diagnostics.cpp's few draws: R-hat and the effective draws by the formulas of Vehtari, Gelman, Simpson,
Carpenter and Buerkner, 2021, doi:10.1214/20-BA1221, section 4, with nothing of decid's."""
import math
import statistics

MIXED = [[(7 * i * i + 3 * i + 5 * c * c + 11 * c) % 29 / 4 + 0.3 * c * (i % 3) for i in range(12)] for c in range(3)]
SLOW = [[(c * 5 + i * (2 + c)) % 31 + 3.0 * i for i in range(12)] for c in range(3)]


def split(chains):
    return [half for chain in chains for half in (chain[:len(chain) // 2], chain[-(len(chain) // 2):])]


def scores(chains):
    values = sorted(value for chain in chains for value in chain)

    def rank(value):
        return sum(i + 1 for i, other in enumerate(values) if other == value) / values.count(value)

    return [[statistics.NormalDist().inv_cdf((rank(v) - 3 / 8) / (len(values) + 1 / 4)) for v in chain] for chain in chains]


def variances(chains):
    """Within the chains, and pooled."""
    n = len(chains[0])
    within = statistics.mean(statistics.variance(chain) for chain in chains)
    return within, (n - 1) / n * within + statistics.variance(statistics.mean(chain) for chain in chains)


def plain_rhat(chains):
    within, pooled = variances(chains)
    return math.sqrt(pooled / within)


def rhat(chains):
    halves = split(chains)
    middle = statistics.median(value for half in halves for value in half)
    folded = [[abs(value - middle) for value in half] for half in halves]
    return max(plain_rhat(scores(halves)), plain_rhat(scores(folded)))


def effective_draws(chains):
    halves = scores(split(chains))
    n, m = len(halves[0]), len(halves)
    within, pooled = variances(halves)

    def correlation(lag):
        covariance = 0.0  # the biased estimate of each chain, made unbiased at lag 0
        for half in halves:
            mean = statistics.mean(half)
            covariance += sum((half[i] - mean) * (half[i + lag] - mean) for i in range(n - lag)) / n / m
        return 1 - (within - covariance * n / (n - 1)) / pooled

    time, least, lag = -1.0, math.inf, 0
    while lag + 1 < n:
        pair = (1.0 if lag == 0 else correlation(lag)) + correlation(lag + 1)
        if pair < 0:
            break
        least = min(least, pair)
        time += 2 * least
        lag += 2
    return n * m / max(time, 1 / math.log10(n * m))


for chains in (MIXED, SLOW):
    print(repr(rhat(chains)), repr(effective_draws(chains)))
