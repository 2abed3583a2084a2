#!/usr/bin/python3
"""`vrda-player calibrate all --virtual` in its window, operated by a person who has only eyes and hands: this script reads
the screen of an X server and types keys. Every reading must be within 1 px (or its unit's tolerance) of the truth, which
the program tells after each task: "You were 0.3 px from the truth."

usage: by_screen.py PLAYER FONT.ttf [BENCH.toml] [--step STEP] [--seed N] [--pictures DIR]
Without BENCH.toml the built-in bench is calibrated with all repeats. Exit code 1 if a reading is too far off.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import numpy
from PIL import Image, ImageDraw, ImageFont

WIDTH, HEIGHT = 1280, 1024
LEFT, TOP, LINE = 12, 12, 19  # of the panel's text: margins and line spacing, px
PANEL = 640  # width of the operator's area
EYES = {False: (640, 16), True: (640, 528)}  # corner of each eye's window (left, right); 640 x 480
FONT_PX = 15  # ascent and descent
MOST_PX, MOST_MM = 1.0, 3.0
OVER = 16  # oversampling of glyph templates


class Screen:
    """An X server without a display; its screen is a file in memory (XWD)."""

    def __init__(self, folder):
        read, write = os.pipe()
        self.process = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-fbdir", folder, "-nolisten", "tcp"],
            pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as line:
            self.display = ":" + line.readline().strip()
        self.file = pathlib.Path(folder) / "Xvfb_screen0"

    def pixels(self):
        data = self.file.read_bytes()
        head = int.from_bytes(data[:4], "big")
        n_colours = int.from_bytes(data[76:80], "big")
        start = head + 12 * n_colours
        rows = numpy.frombuffer(data, numpy.uint8, WIDTH * HEIGHT * 4, start).reshape(HEIGHT, WIDTH, 4)
        return rows[:, :, 2::-1].astype(float)

    def end(self):
        self.process.terminate()
        self.process.wait(20)


def linear(codes):
    """Light of sRGB codes, 0 to 1; text is blended in linear light."""
    shares = codes / 255
    return numpy.where(shares < 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


class Reader:
    """Reads the panel's text: matches glyphs of the known font at the known positions."""

    CHARACTERS = [chr(c) for c in range(32, 127)]
    WIDE = 18  # columns of a template, the pen is in column 2

    def __init__(self, font_file):
        probe = ImageFont.truetype(font_file, 1000)
        ascent, descent = probe.getmetrics()
        em = FONT_PX / ((ascent + descent) / 1000)
        font = ImageFont.truetype(font_file, round(em * OVER))
        base = round(FONT_PX * ascent / (ascent + descent))
        self.advance = numpy.array([probe.getlength(c) * em / 1000 for c in self.CHARACTERS])
        # Linear interpolation of the font image, which has two columns per pixel.
        triangle = numpy.bartlett(OVER + 1)
        triangle /= triangle.sum()
        drawn = []
        for character in self.CHARACTERS:
            image = Image.new("L", (self.WIDE * OVER, LINE * OVER))
            ImageDraw.Draw(image).text((2 * OVER, base * OVER), character, 255, font, anchor="ls")
            rows = numpy.asarray(image, float) / 255
            drawn.append(numpy.apply_along_axis(lambda row: numpy.convolve(row, triangle, "same"), 1,
                                                rows.reshape(LINE, OVER, -1).mean(axis=1)))
        # By phase of the pen in eighths of a pixel: coverage of every character, and the columns that count.
        self.templates = [numpy.roll(numpy.array(drawn), phase * OVER // 8, axis=2)
                          .reshape(len(drawn), LINE, self.WIDE, OVER).mean(axis=3) for phase in range(8)]
        columns = numpy.arange(self.WIDE)
        self.counts = [columns[None, :] < (2 + phase / 8 + self.advance)[:, None] for phase in range(8)]
        self.known = {}

    def costs(self, strip, column, phase):
        """Squared differences of all characters with the pen at column + phase / 8, over their advance."""
        seen = strip[:, column - 2:column - 2 + self.WIDE]
        off = ((self.templates[phase] - seen[None]) ** 2).sum(axis=1)
        off[:, :2] = 0
        return (off * self.counts[phase]).sum(axis=1)

    def line(self, strip):
        """Text of a strip of LINE rows, whose pen starts at LEFT."""
        key = strip.tobytes()
        if key in self.known:
            return self.known[key]
        lit = numpy.flatnonzero(strip.max(axis=0) > 0.3)
        if not len(lit):
            return ""
        end, cache = lit[-1] - 0.5, {}
        beams, done = [(0.0, float(LEFT), "")], []
        while beams:
            following = []
            for cost, pen, text in beams:
                if pen > end:
                    done.append((cost, text))
                    continue
                at = round(pen * 8)
                if at not in cache:
                    cache[at] = self.costs(strip, at // 8, at % 8)
                costs = cache[at]
                for k in numpy.argsort(costs / self.advance)[:4]:
                    following.append((cost + costs[k], pen + self.advance[k], text + self.CHARACTERS[k]))
            beams = sorted(following, key=lambda beam: beam[0] / (beam[1] - LEFT))[:12]
        # No text that matters has a capital I or a semicolon, which look like l and a comma.
        self.known[key] = min(done)[1].rstrip().replace("I", "l").replace(";", ",")
        return self.known[key]

    def text(self, pixels):
        panel = pixels[:, :PANEL].max(axis=2)
        lines = []
        for top in range(TOP, HEIGHT - LINE, LINE):
            light = linear(panel[top:top + LINE])
            if light.max() < 0.1:
                break
            paper = linear(numpy.array(32.0))
            lines.append(self.line(numpy.clip((light - paper) / (light.max() - paper), 0, 1)))
        return lines


def colours(pixels, corner):
    """Shares of white and amber of an eye's window."""
    x, y = corner
    window = pixels[y:y + 480, x:x + 640] / 255
    red, blue = window[:, :, 0], window[:, :, 2]
    white = numpy.clip((blue - 0.45) / 0.5, 0, 1)
    amber = numpy.clip((red - blue - 0.2) / 0.4, 0, 1) * (blue < 0.45)
    return white, amber


def centre(weight):
    y, x = numpy.mgrid[:weight.shape[0], :weight.shape[1]]
    return numpy.array([(x * weight).sum(), (y * weight).sum()]) / weight.sum()


def ring_centre(amber):
    """Centre of the least-squares circle through the bright pixels: of a ring, even if a cross covers parts of it."""
    y, x = numpy.nonzero(amber > 0.75)
    root = numpy.sqrt(amber[y, x])
    rows = numpy.stack([2 * x, 2 * y, numpy.ones_like(x)], axis=1) * root[:, None]
    return numpy.linalg.lstsq(rows, (x ** 2 + y ** 2) * root, rcond=None)[0][:2]


class Person:
    def __init__(self, player, font, bench, step, seed, pictures):
        self.folder = tempfile.TemporaryDirectory(prefix="vrda-by-screen-")
        self.screen = Screen(self.folder.name)
        self.reader = Reader(font)
        self.pictures = pictures
        self.environment = {**os.environ, "DISPLAY": self.screen.display}
        words = [os.path.abspath(player), "calibrate", step, "--virtual", "--seed", str(seed), "--quiet"]
        self.program = subprocess.Popen([*words, "--bench", os.path.abspath(bench)] if bench else words, env=self.environment,
                                        stdout=subprocess.DEVNULL, cwd=self.folder.name)
        self.off, self.done = [], 0

    def end(self):
        if self.program.poll() is None:
            self.program.terminate()
        self.program.wait(20)
        self.screen.end()
        self.folder.cleanup()

    def keys(self, *keys):
        if not keys:
            return
        for k in range(0, len(keys), 60):
            subprocess.run(["xdotool", "key", "--delay", "2", *keys[k:k + 60]], env=self.environment, check=True)

    def steps(self, key, n):
        """Presses for n steps: hundreds, tens, ones."""
        return ["ctrl+" + key] * (n // 100) + ["shift+" + key] * (n // 10 % 10) + [key] * (n % 10)

    def turned(self, dial, n):
        """Turns a dial (0 or 1) by n steps and looks again once the panel says so."""
        pixels = self.screen.pixels()
        if n == 0:
            return pixels
        wanted = self.value(self.read(pixels), dial) + n * self.step
        more, less = (("Right", "Left"), ("Up", "Down"))[dial]
        if self.is_cross and dial == 1:
            wanted -= 2 * n * self.step  # Up decreases y
        self.keys(*self.steps(more if n > 0 else less, abs(n)))
        for _ in range(200):
            pixels = self.screen.pixels()
            time.sleep(0.03)
            if abs(self.value(self.read(pixels), dial) - wanted) < 0.5 * self.step:
                return self.screen.pixels()  # the picture above may have been of half a frame
        raise RuntimeError(f"a dial does not reach {wanted}: {self.read(pixels)}")

    def read(self, pixels):
        return self.reader.text(pixels)

    def value(self, lines, dial):
        """What the panel says of a dial: "Left, Right: column 132 px"."""
        mark = ("Left, Right: ", "Up, Down: ")[dial]
        line = next(line for line in lines if line.startswith(mark))
        return float(re.findall(r"-?\d+(?:\.\d+)?", line)[-1])

    def confirm(self, task):
        """Presses Enter and waits for the next task; reads how far off this one was."""
        self.keys("Return")
        for _ in range(1200):
            time.sleep(0.05)
            pixels = self.screen.pixels()
            lines = self.read(pixels)
            if lines and task_of(lines) != task:
                return pixels, lines
        raise RuntimeError(f"{task}: nothing happened; the panel says {lines}")

    def scan(self, pixels, right, column):
        """The last (or first) column of which at least half is visible, by the line's distance from the edge."""
        flat = (lambda w: w) if column else (lambda w: w.T)

        def distance(pixels):
            white, amber = map(flat, colours(pixels, EYES[right]))
            line = centre(white[200:280] if column else white[250:390])[0]
            rows = slice(200, 280) if column else slice(250, 390)
            halves = amber[rows].copy()
            # Of the two edges, the nearer one.
            x = numpy.arange(halves.shape[1])
            side = halves * (x < halves.shape[1] / 2 if line < halves.shape[1] / 2 else x >= halves.shape[1] / 2)
            return line - centre(side)[0]

        off = distance(pixels)
        towards, scale = (-1 if off > 0 else 1), 1.5
        # The optics magnify more at the edge: the line comes nearer by a part of the rest, not to vanish beyond it.
        while abs(off) > 12 * scale:
            n = max(1, int(0.6 * abs(off) / scale))
            pixels = self.turned(0, towards * n)
            scale, off = (abs(off) - abs(distance(pixels))) / n, distance(pixels)
        pixels = self.turned(0, -towards * 10)
        scale = (abs(distance(pixels)) - abs(off)) / 10
        # The reading's pixel is visible to its middle: the line is half a pixel inside the edge on average.
        self.turned(0, towards * (10 + round(abs(off) / scale - 0.5)))

    def moved(self, pixels, dial, goal, seen):
        """Turns the dial until what `seen` measures is at the goal, by the scale that the first moves show."""
        scale = 0.9 * self.step
        for _ in range(6):
            at = seen(pixels)
            n = round((goal - at) / scale)
            if n == 0:
                break
            pixels = self.turned(dial, n)
            if abs(n) > 10:
                scale = (seen(pixels) - at) / n
        return pixels

    def cross(self, pixels, right):
        """Moves the white cross to the middle of the amber ring."""
        goal = ring_centre(colours(pixels, EYES[right])[1])
        for _ in range(2):  # the optics turn the dials' axes
            pixels = self.moved(pixels, 0, goal[0], lambda p: centre(colours(p, EYES[right])[0])[0])
            # Up moves it up: to smaller y.
            pixels = self.moved(pixels, 1, -goal[1], lambda p: -centre(colours(p, EYES[right])[0])[1])

    def sides(self, pixels, right):
        """Moves both white lines to the amber sides, at the height of the eye."""
        rows = slice(238, 243)

        def ends(weight):
            row = weight[rows].sum(0)
            x = numpy.flatnonzero(row > 0.3 * row.max())
            groups = numpy.split(x, numpy.flatnonzero(numpy.diff(x) > 2) + 1)
            return [(row[g] * g).sum() / row[g].sum() for g in (groups[0], groups[-1])]

        goal = ends(colours(pixels, EYES[right])[1])
        for dial in (0, 1):
            pixels = self.moved(pixels, dial, goal[dial], lambda p, dial=dial: ends(colours(p, EYES[right])[0])[dial])

    def number(self, lines):
        reading = float(re.search(r"Reading: (-?[\d.]+)", "\n".join(lines)).group(1))
        self.turned(0, round((reading - self.value(lines, 0)) / self.step))

    def work(self):
        subprocess.run(["xdotool", "mousemove", "300", "700"], env=self.environment, check=True)
        for _ in range(600):
            time.sleep(0.1)
            if self.program.poll() is not None:
                raise RuntimeError("the program ended")
            pixels = self.screen.pixels()
            lines = self.read(pixels)
            if lines and lines[0].startswith("Part 1"):
                break
        while not any("All requested parts are done" in line for line in lines):
            task = task_of(lines)
            right = "right eye" in task
            is_number = any(line.startswith("Reading: ") for line in lines)
            is_scan = re.search(r"\bedge, \d", task)
            self.step = 1.0 if is_scan or "image distance" in task else 0.05 if is_number else 0.25
            self.is_cross = "node" in task or "place" in task
            if is_scan:
                self.scan(pixels, right, "left edge" in task or "right edge" in task)
            elif self.is_cross:
                self.cross(pixels, right)
            elif "rectangle" in task:
                self.sides(pixels, right)
            elif is_number:
                self.number(lines)
            if self.pictures and self.done % 10 == 0:
                Image.fromarray(self.screen.pixels().astype(numpy.uint8)).save(f"{self.pictures}/task_{self.done:03}.png")
            pixels, lines = self.confirm(task)
            self.done += 1
            self.judge(task, lines)
        self.keys("Return")
        self.program.wait(30)

    def judge(self, task, lines):
        words = next((line for line in lines if line.startswith("You were ")), None)
        if words is None:
            print(f"{task}: done", flush=True)
            return
        value, unit = re.match(r"You were ([\d.]+) ?(\w*) from", words).groups()
        self.off.append((task, float(value), unit))
        print(f"{task}: {value} {unit}", flush=True)


def task_of(lines):
    """Part and name of the task: "viewport, left eye, left edge, 1"."""
    found = re.match(r"Part \d+ of \d+: (\w+), \d+ of \d+, (.*)", lines[0] if lines else "")
    return ", ".join(found.groups()) if found else " ".join(lines[:1])


def main():
    options = argparse.ArgumentParser()
    options.add_argument("player")
    options.add_argument("font")
    options.add_argument("bench", nargs="?")
    options.add_argument("--step", default="all")
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--pictures")
    chosen = options.parse_args()
    person = Person(chosen.player, chosen.font, chosen.bench, chosen.step, chosen.seed, chosen.pictures)
    began = time.time()
    try:
        person.work()
    finally:
        person.end()
    most = {"px": MOST_PX, "mm": MOST_MM}
    bad = [off for off in person.off if off[1] > most[off[2]]]
    px = [off[1] for off in person.off if off[2] == "px"]
    print(f"{person.done} tasks in {time.time() - began:.0f} s, {len(px)} readings in px, the largest {max(px)} px from the truth")
    for task, value, unit in bad:
        print(f"{task}: found {value} {unit} from the truth, wanted at most {most[unit]}", file=sys.stderr)
    return 1 if bad or not px else 0


if __name__ == "__main__":
    sys.exit(main())
