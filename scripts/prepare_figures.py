"""Pictures of scripts/prepare_trials, small enough to be kept."""
import matplotlib
from PIL import Image

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "vrda"  # reproducible output
from matplotlib import pyplot  # noqa: E402

HALF = 2  # prepare.png is four views of 800 pixels
INTERNAL = 0  # of the coordinates of a curve


def keep(image, path):
    path.parent.mkdir(exist_ok=True)
    image.save(path, quality=80, optimize=True)


def keep_picture(source, path):
    """prepare.png at half its size."""
    image = Image.open(source).convert("RGB")
    keep(image.resize((image.width // HALF, image.height // HALF), Image.Resampling.LANCZOS), path)


def keep_row(sources, path):
    """Frames of the player side by side."""
    images = [Image.open(source).convert("RGB") for source in sources]
    width, height = images[0].size
    row = Image.new("RGB", (width * len(images), height))
    for number, image in enumerate(images):
        row.paste(image, (number * width, 0))
    keep(row, path)


def draw_curves(numbers, path):
    """Internal rotation of each knee over flexion, with the template's, one panel per template."""
    figure, axes = pyplot.subplots(1, 2, figsize=(11, 4.2), layout="constrained", sharey=True)
    for ax, group, title in zip(axes, ("solved", "generic"), ("by the jam-smith2019 template", "by the generic template")):
        by_knee = numbers[group]
        lines = {name: found["motion"] for name, found in by_knee.items() if "motion" in found}
        for name, rows in {"jam-smith2019, its own job": numbers["template"], **lines}.items():
            is_own = rows is numbers["template"]
            flexions = sorted(map(int, rows))
            ax.plot(flexions, [rows[str(flexion)][INTERNAL] for flexion in flexions], color="0.25" if is_own else None, lw=2.5 if is_own else 1.5,
                    ls="--" if is_own else "-", label=name)
        ax.set(title=title, xlabel="flexion, degrees")
        ax.grid(alpha=0.3)
    axes[0].set_ylabel("internal rotation, degrees")
    axes[1].legend(frameon=False, fontsize=8)
    figure.savefig(path, metadata={"Date": None})
    pyplot.close(figure)
