"""The table of versions in schemas/README.md has the versions that the sources write."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# Row of the table: source, and what is around the number there.
WRITTEN = {
    "motion model": ("pipeline/store/motion_model.hpp", r'\bformat_version = "([\d.]+)"'),
    "trace": ("pipeline/store/registry.hpp", r'\btrace_format_version = "([\d.]+)"'),
    "table of a campaign, `index.h5`": ("pipeline/store/solved_cells.hpp", r'\bindex_format_version = "([\d.]+)"'),
    "`rom.json`": ("pipeline/analysis/rom_files.cpp", r"\brom_version = (\d+)"),
    "`laxity.json`, `fit.json`": ("pipeline/analysis/laxity.cpp", r'\{"version", (\d+)\}'),
    "view state, lesson": ("player/web/page/view_state.js", r"\bversion = (\d+)"),
    "serial protocol": ("schemas/serial-protocol.md", r"protocol, version (\d+)"),
    "stream of a bench": ("schemas/live.md", r"`version` \| (\d+)"),
    "calibration": ("schemas/calibration.schema.json", r'"version": \{"type": "number", "minimum": 1, "maximum": (\d+)'),
    "recording of a bench": ("player/bench/recording.cpp", r'"VRDABREC", (\d+)'),
    "submission": ("pipeline/run/submission.cpp", r'"vrda submission (\d+)"'),
    "journal of a run": ("pipeline/store/journal.cpp", r'"VRDAJRNL", (\d+)'),
}


class Versions(unittest.TestCase):
    def test_the_table_has_what_the_sources_write(self):
        table = (ROOT / "schemas/README.md").read_text(encoding="utf-8").split("## Versions")[1].split("\n## ")[0]
        rows = dict(re.findall(r"^\| ([^|]+?) \| ([\d.]+) \|", table, re.MULTILINE))
        found = {name: re.search(form, (ROOT / file).read_text(encoding="utf-8")).group(1) for name, (file, form) in WRITTEN.items()}
        self.assertEqual(rows, found)


if __name__ == "__main__":
    unittest.main()
