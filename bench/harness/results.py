"""A run's results as one file in Google Benchmark's JSON schema, context and benchmarks, with the machine in the context:
what bench/history keeps and trackers read."""
import math
import re

from harness.project import Failed

# Fields without use elsewhere, which may identify the user.
PRIVATE = ("host_name", "executable")


def rounded(value):
    """Six significant digits: no clock knows more."""
    if isinstance(value, float) and math.isfinite(value) and value != 0:
        return round(value, 5 - math.floor(math.log10(abs(value))))
    return value


def join(measured, **context):
    """One result of many (context, benchmark), of whose contexts the first counts; `context` is added to it."""
    first = {key: value for key, value in measured[0][0].items() if key not in PRIVATE}
    entries, seen = [], set()
    for index, (_, entry) in enumerate(measured):
        if entry["name"] in seen:
            raise Failed(f"{entry['name']}: is there twice")
        seen.add(entry["name"])
        entries.append({key: rounded(value) for key, value in {**entry, "family_index": index}.items()})
    return {"context": {**first, **context}, "benchmarks": entries}


def of_machine(entry):
    """Returns the percentage of the machine's peak that a benchmark reaches, and which peak: (52.1, "%peak")."""
    for key in ("%peak", "%bandwidth"):
        if key in entry:
            return entry[key], key
    raise Failed(f"{entry['name']}: is not put beside the machine: no %peak or %bandwidth")


def threads_of(benchmarks):
    """The numbers of threads that names speak of, "1, 2"; the others run on one."""
    found = {int(n) for b in benchmarks for n in re.findall(r"/threads:(\d+)", b.name)} | {1}
    return ", ".join(str(n) for n in sorted(found))
