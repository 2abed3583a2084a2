"""results/tutorial.md from what the steps of scripts/tutorial printed; their pictures are beside it."""
import re


def page(record, stamp):
    """The page: TEXT, in which [[NAME: ALT]] is the step NAME with its picture, and [[cells]] the notebook."""
    steps = {step["name"]: step for step in record["steps"]}

    def shown(match):
        name, alt = match.groups()
        commands, output = "\n".join(steps[name]["commands"]), "\n".join(steps[name]["output"])
        parts = [f"```sh\n{commands}\n```"] * bool(commands) + [f"```text\n{output}\n```"] * bool(output) + [f"![{alt}](tutorial/{name}.jpg)"] * bool(alt)
        return "\n\n".join(parts)

    text = re.sub(r"\[\[([\w-]+)(?:: ([^\]]+))?\]\]", shown, TEXT.replace("[[cells]]", cells(record["cells"])))
    seconds = sum(step["seconds"] for step in record["steps"])
    return text.replace("STAMP", stamp).replace("SECONDS", f"{seconds:.0f}")


def cells(found):
    """The notebook as text."""
    parts = []
    for cell in found:
        if cell["kind"] == "markdown":
            parts.append(re.sub(r"^# .*\n+", "", cell["source"]))
            continue
        parts.append(f"```python\n{cell['source']}\n```")
        if cell["output"].strip() and not cell["pictures"]:
            parts.append(f"```text\n{cell['output'].rstrip()}\n```")
        parts += [f"![Figure of the notebook](tutorial/{picture})" for picture in cell["pictures"]]
    return "\n\n".join(parts)


TEXT = """# Ten minutes with VRDA

Written by `scripts/tutorial`, which runs every command of this page in an empty folder: SECONDS s for all of them. `vrda` and `vrda-player` are the programs that
`scripts/quickstart` builds. Output is shortened.

STAMP

[From two meshes](#from-two-meshes) - [from a segmentation in 3D Slicer](#from-a-segmentation-in-3d-slicer) - [from an OpenSim model](#from-an-opensim-model) - [in Python](#in-python)

## From two meshes

Meshes of femur and tibia, in one scan. In place of yours, those of the template:

[[shape]]

`prepare` finds unit, side and frames, transfers ligaments and writes a job. Its picture has to show your knee: the axes in the bones, the fibres on them. Each warning says what was assumed.

[[prepare: Femur and tibia with their frames and the transferred fibres]]

`check` prints what the program reads from a job, and draws it.

[[check: The joint of the job]]

`run` solves it; `show` draws the result. The fibres are light orange to dark red by strain, grey where they are slack, violet beyond 8 %.

[[run: The knee at 0, 30, 60 and 90 degrees of flexion]]

The report is one HTML page. It begins with what the motion is worth: how much of it was decided by the prior, the mean motion of cadaver knees ([believable.md](believable.md)).

[[report: The beginning of the report]]

In a browser, on this computer or on a phone: `vrda-player web my-knee.h5`, then open the address that it prints.

[[web: The page, at 45 degrees of flexion]]

## From a segmentation in 3D Slicer

`segmentation/` has what Slicer exports: meshes whose header says `SPACE=LPS`, and points in `points.mrk.json`, here both epicondyles and the head of the fibula ([schemas/slicer.md](../schemas/slicer.md)). The
script makes it from the same bones, turned and moved as a scanner has them. `--no-prior` leaves the mean motion out: bones and ligaments decide alone.

[[slicer-prepare: The segmented bones in their frames]]

[[slicer-run: The segmented knee at 0, 30, 60 and 90 degrees]]

Back: meshes and points of a pose in the axes of the scan, to drop onto the volume.

[[slicer-back: The pose at 30 degrees over the scan]]

## From an OpenSim model

A model to start from, in place of yours: the generic knee of `jobs/`, as OpenSim has it.

[[osim-model]]

`convert osim` makes a job of one of its joints, with meshes, ligaments and kneecap, and lists what is not taken over ([schemas/osim.md](../schemas/osim.md)). The
menisci of this knee carry load, so `--drawn` names the meshes that are only drawn; `--muscles 1` takes the actuators of the kneecap with their whole force.

[[osim-convert: The joint of the OpenSim model]]

Its motion, and that of its kneecap, are those of the knee before the way through OpenSim, to the last digit that `score` prints:

[[osim-run: The joint of the OpenSim model at 0, 30, 60 and 90 degrees]]

## In Python

`scripts/quickstart --python` builds the module, `pip install --no-build-isolation --no-index .` installs it ([schemas/README.md](../schemas/README.md#python)). The following is
[knee.ipynb](../pipeline/python/examples/knee.ipynb), executed. In place of a measured motion it has that of the generic knee:

[[measured]]

[[cells]]
"""
