"""results/fuzz.md from the logs of scripts/fuzz --record."""
import re

READER = ("reader", "seconds", "runs", "coverage", "peak_mb", "crashes")


def outcomes(text):
    """Counts that a test printed as `outcome: N WORDS`."""
    return [[int(count), words] for count, words in re.findall(r"^outcome: ([0-9]*) (.*)$", text, re.M)]


def collect(readers, models_log, mutants_log):
    """A tab-separated line per reader, and the logs of the model reader and of the mutated files."""
    models, mutants = models_log.read_text(), mutants_log.read_text()
    rows = [dict(zip(READER, line.split("\t"))) for line in readers.read_text().splitlines()]
    return {"readers": rows, "model_files": (re.findall(r"^files: (.*)$", models, re.M) or [""])[-1], "models": outcomes(models),
        "mutants": 10000, "mutant_outcomes": outcomes(mutants),
            "remarks": []}


def page(n, stamp):
    """The page."""
    rows = "\n".join("| " + " | ".join(str(one[key]) for key in READER) + " |" for one in n["readers"])
    listed = lambda found: "\n".join(f"- {count}: {what}" for count, what in found)
    remarks = "".join(f"{line}\n\n" for line in n["remarks"])
    return f"""# Fuzzing the readers

Written by `scripts/fuzz --record`: libFuzzer with address and undefined-behaviour checks, one reader after the other, from
the seeds in `tests/fuzz/corpus`. A value or one error message is correct; anything else, 2 s of processor time or 512 MB is a crash.

{stamp}

| reader | s | runs | coverage, edges | peak memory, MB | crashes |
|---|---:|---:|---:|---:|---:|
{rows}

A run of `models` is 64 motion models or traces, HDF5 files with valid seals and checksums, mutated in their bytes or through HDF5, read in another process as the player
reads them ({n['model_files']} files). If HDF5
terminates that process, the player reports one message. Counts, with the code that caused the end, libhdf5 or VRDA, and its signal or sanitizer report:

{listed(n['models'])}

{n['mutants']} mutated motion models, traces and journals with valid checksums, each passed to `info`, `validate`, `smooth`, `export` or `merge`: no signal, at most
600 MB and 10 s of processor time, each error message names the file; the outcomes:

{listed(n['mutant_outcomes'])}

{remarks}{FAULTS}"""


# The counts of the fault injection are those that its tests print.
FAULTS = """## Faults of the file system

The system calls of a command on its files in turn are killed, fail (EIO, ENOSPC, a disk full from there on), are short, or write half and are killed (torn). Then the same
command without a fault must give the same bytes and no other file. `VRDA_FAULTS_ALL=1 build/release/tests/faults/test_faults` prints these counts ("trials:").

| command | kill | torn | short | EIO | ENOSPC, full disk | results lost or damaged |
|---|---:|---:|---:|---:|---:|---:|
| run | 244 | 258 | 113 | 276 | 104 | 0 |
| run that resumes an interrupted one | 190 | 193 | 190 | 190 | 190 | 0 |
| run of the spine or a shard | 145 | 77 | 6 | 28 | | 0 |
| merge | 90 | 12 | 2 | 14 | | 0 |
| submit | 197 | 199 | | 197 | | 0 |
| resume | 180 | 180 | 180 | 180 | 180 | 0 |
| smooth | 18 | | 18 | 18 | 18 | 0 |
| audit | 18 | | 18 | 18 | 18 | 0 |
| reduce | 18 | | 18 | 18 | 18 | 0 |
| export | 10 | | 10 | 10 | 10 | 0 |
| compare | 4 | | 4 | 4 | 4 | 0 |

In two earlier trials of `resume`, with EIO and with ENOSPC, a temporary file of a previously killed submission remained because its removal failed; the removal is now repeated. The counts of `resume` are of the program with this change.
"""
