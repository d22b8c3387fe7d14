"""Two programs measured in turns: the median ratio of their pairs, and a confidence interval that assumes nothing of
how times scatter. Between the k-th smallest and the k-th largest of n ratios lies the median of their distribution
unless fewer than k of them fell on one side of it: Conover, Practical Nonparametric Statistics, 3.2."""
from dataclasses import dataclass
from math import comb, log
from statistics import median

CONFIDENCE = 0.95
FEWEST = 9  # pairs: one may fall outside on each side, and the interval still holds with 96%


def rank(pairs, confidence=CONFIDENCE):
    """The largest k for which the k-th smallest and largest of `pairs` values enclose the median with `confidence`; 0
    if not even the smallest and the largest do."""
    below, best = 0, 0
    for k in range(1, pairs // 2 + 1):
        below += comb(pairs, k - 1)  # patterns, of 2^pairs, with fewer than k on one side
        if 1 - 2 * below / 2**pairs < confidence:
            break
        best = k
    return best


@dataclass(frozen=True)
class Change:
    """New over old of one benchmark: 1.1 is 10% slower."""
    name: str
    ratio: float
    low: float
    high: float
    minimum: float

    @property
    def slower(self):
        return self.low > 1 and self.ratio > 1 + self.minimum

    @property
    def faster(self):
        return self.high < 1 and self.ratio < 1 / (1 + self.minimum)

    @property
    def verdict(self):
        return "SLOWER" if self.slower else "faster" if self.faster else "-"


def change(name, old, new, minimum):
    """Compares two lists of times, pair by pair in the order of measurement."""
    if len(old) != len(new) or len(old) < FEWEST:
        raise ValueError(f"{name}: needs {FEWEST} pairs or more, has {len(old)} and {len(new)} times")
    ratios = sorted(b / a for a, b in zip(old, new))
    k = rank(len(ratios))
    return Change(name, median(ratios), ratios[k - 1], ratios[-k], minimum)


def exponent(sizes, values):
    """Least squares in log-log: b of value = a size^b."""
    if len(sizes) != len(values) or len(set(sizes)) < 2 or min([*sizes, *values]) <= 0:
        raise ValueError("an exponent needs positive values at two sizes or more")
    x, y = [log(s) for s in sizes], [log(v) for v in values]
    x_mean, y_mean = sum(x) / len(x), sum(y) / len(y)
    return (sum((a - x_mean) * (b - y_mean) for a, b in zip(x, y)) / sum((a - x_mean)**2 for a in x))
