#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Runs the smallest sweep: its files are whole, and its figures are of the size that they should have.

Usage: bench_pareto_test.py BENCH_PARETO
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    subprocess.run([sys.argv[1], "--tiny", "--out", folder], check=True, timeout=1400)
    rows = list(csv.DictReader(open(folder / "pareto.csv")))
    page = json.loads((folder / "pareto.json").read_text())
    assert len(rows) == len(page["rows"]) > 20
    for row, same in zip(rows, page["rows"]):
        assert row["estimator"] == same["estimator"] and float(row["force_rms"]) == same["force_rms"]
        assert 0 < same["p50_us"] <= same["p99_us"] <= same["p999_us"] and same["pairs"] > 0, same
        assert same["bytes"] is None if same["spheres"] == 0 else same["bytes"] > 1e4, same
        assert 0 <= same["force_rms"] and same["force_size_rms"] <= same["force_rms"] * (1 + 1e-6), same
        assert 0 <= same["direction_deg"] <= 180, same

    def one(estimator, spheres, overlap):
        (found,) = [r for r in page["rows"] if r["estimator"] == estimator and r["spheres"] == spheres and r["overlap"] == overlap]
        return found

    leaves, coarse, paper, closed = (one(e, 400, 0.1) for e in ("level 0", "level 4", "paper", "closed form"))
    assert leaves["force_rms"] < 0.1 and abs(leaves["volume_bias"]) < 0.05, leaves
    assert coarse["pairs"] < leaves["pairs"] / 3 and coarse["force_rms"] > leaves["force_rms"], coarse
    # What the packed spheres share is a lower bound.
    assert paper["volume_bias"] < -0.1, paper
    assert closed["force_rms"] < 0.1 and closed["pairs"] < leaves["pairs"], closed
    assert one("level 0", 100, 0.1)["pairs"] < leaves["pairs"]

    # On paths. A half of the spacing of floats at 1 km, twice in three axes, over the depth of the contact.
    depths = {(r["spheres"], r["overlap"]): r["depth_over_gap"] for r in page["rows"]}
    assert depths[400, 0.1] > depths[400, 0.01] > depths[100, 0.01] > 0, depths
    for row in page["rows"]:
        assert row["z_width"] is not None and abs(row["z_width"] * (0.5e-3 + 1e-6 * row["p999_us"]) - 5) < 1e-3, row
        assert row["explicit_k"] > 0 and row["implicit_step"] > 0 and row["noise_50hz"] >= 0 and row["loop_work"] >= 0, row
    assert leaves["noise_50hz"] < 1e-3 and leaves["loop_work"] < 0.02, leaves
    assert abs(leaves["rest_depth"]) < 0.01 and 0 < leaves["in_float_1km"] < 0.01, leaves
    # Forces along the lines between the centres have a potential; those that it has are too small, so that bodies rest deeper.
    assert paper["loop_work"] < 1e-5 and one("paper", 400, 0.01)["rest_depth"] > 0, paper
    gimpact = one("Bullet GImpact, all contacts", 0, 0.1)
    assert gimpact["volume_bias"] is None and gimpact["noise_50hz"] > leaves["noise_50hz"], gimpact
    assert gimpact["force_rms"] > leaves["force_rms"], gimpact
    assert one("budget 100", 400, 0.1)["pairs"] <= 100
    for promise in page["promises"]:
        assert promise["held"] > 0.6 and promise["of_leaves"] <= 1.01, promise
    assert any(p["kept"] > 0 for p in page["promises"])

    html = (folder / "pareto.html").read_text()
    assert html.startswith("<!DOCTYPE html>") and html.rstrip().endswith("</html>") and html.count("<svg") == 2 and "on paths" in html
    assert "src=" not in html and "nan" not in html
    xml.etree.ElementTree.fromstring((folder / "front-box-ball.svg").read_text())
for wrong in [["--tiny", "--nonsense", "1"], ["--tiny", "--pairs", "box"], ["--passes", "many"], ["--spheres", "100,x"], ["--paths"]]:
    assert subprocess.run([sys.argv[1], *wrong], capture_output=True).returncode == 2, wrong
print("the files are whole")
