#!/usr/bin/env python3
"""Guards against getting worse: compares every method's errors with ceilings, and its cost with what
it was, as ratios to rays traced in the same run, so that the machine's speed does not matter; in time of
the processor, so that what else runs does not matter much.

    tools/bench_check.py BUILD             says what got worse; exit status 1 if anything did
    tools/bench_check.py BUILD --update    measures and writes bench/check.json anew

An error is worse when it is above its ceiling: what was measured at the last update and 5 % (leaks and
darkening: 0.2 % of the pixels) more. A cost is worse when a method's mean ratio over its scenes grew
by more than half, or a single one to five times. Times are noisy: what costs more is measured again,
three times in all, and the least times count. Rows below a millisecond are not judged.
Ratios differ between kinds of processors and renderers: on another one than the table's, costs are
notes and only errors can get worse.
"""
import json
import math
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TABLE = os.path.join(ROOT, "bench", "check.json")
SCENES = ["two-boxes", "knot", "fence", "spheres-3x3x3", "jack-tube", "light-size-3", "blocker", "room",
          "outdoor", "caster-through-light-plane"]
YARDSTICK = "reference:64"
ERRORS = {"rmse": (1.05, 0.0005), "p99_error": (1.05, 0.002), "umbra_leak": (1, 0.002),
          "lit_darkening": (1, 0.002)}
MEAN_COST, SINGLE_COST, NOTHING_MS = 1.5, 5.0, 1.0
TURNS = 3


def measure(build):
    folder = os.path.join(ROOT, build, "bench-check")
    command = [os.path.join(ROOT, build, "penumbra"), "compare", *("builtin:" + s for s in SCENES),
               "--methods", "all," + YARDSTICK, "-s", "160x120", "--truth-samples", "1024",
               "--threads", "1", "-q", "-o", folder]
    print("$", " ".join(["penumbra"] + command[1:]))
    subprocess.run(command, check=True, cwd=ROOT)
    with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
        report = json.load(file)
    rows = {"": {"processor": report["processor"], "renderers": sorted(
        {m["device"] for s in report["scenes"] for m in s["methods"]} - {report["processor"]})}}
    for scene in report["scenes"]:
        found = {m["label"]: m for m in scene["methods"]}
        unit = found[YARDSTICK]["processor_milliseconds"]
        for label, m in found.items():
            if not m["pixels"]:
                continue
            row = {key: m[key] for key in ERRORS}
            row["ms"], row["unit"] = m["processor_milliseconds"], unit
            row["cost"] = row["ms"] / unit
            rows[(scene["scene"].removeprefix("builtin:"), label)] = row
    return rows


def update(rows):
    table = {"": rows.pop("")}
    for (scene, label), row in sorted(rows.items()):
        ceilings = {key: round(row[key] * factor + more, 5)
                    for key, (factor, more) in ERRORS.items()}
        table.setdefault(scene, {})[label] = {**ceilings, "cost": float(f"{row['cost']:.3g}")}
    lines = ["{"]
    for i, (scene, methods) in enumerate(table.items()):
        if not scene:
            lines.append(f' "": {json.dumps(methods)},')
            continue
        lines.append(f" {json.dumps(scene)}: {{")
        entries = [f"  {json.dumps(label)}: {json.dumps(row)}" for label, row in methods.items()]
        lines.append(",\n".join(entries))
        lines.append(" }" + ("," if i + 1 < len(table) else ""))
    lines.append("}")
    with open(TABLE, "w", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    print(f"{len(rows)} rows in {os.path.relpath(TABLE, ROOT)}")


def judge(rows, table):
    rows, table = dict(rows), dict(table)
    worse, notes, costs = [], [], {}
    same = rows.pop("") == table.pop("")
    dear = worse if same else notes
    if not same:
        notes.append("another processor or renderer than the table's: costs are not judged")
    for scene, methods in table.items():
        for label, ceiling in methods.items():
            row = rows.pop((scene, label), None)
            if row is None:
                worse.append(f"{scene}: {label}: does not run any more")
                continue
            for key in ERRORS:
                if row[key] > ceiling[key]:
                    worse.append(f"{scene}: {label}: {key} {row[key]:.5f}, ceiling {ceiling[key]:.5f}")
            if row["ms"] < NOTHING_MS or label == YARDSTICK:
                continue
            growth = row["cost"] / ceiling["cost"]
            costs.setdefault(label, []).append(growth)
            if growth > SINGLE_COST:
                dear.append(f"{scene}: {label}: cost {row['cost']:.3g} times {YARDSTICK}, was "
                             f"{ceiling['cost']:.3g}")
    for label, growth in costs.items():
        mean = math.exp(sum(map(math.log, growth)) / len(growth))
        if mean > MEAN_COST:
            dear.append(f"{label}: cost in the mean {mean:.2f} times what it was")
        elif mean < 1 / MEAN_COST:
            notes.append(f"{label}: cost in the mean {mean:.2f} times what it was")
    for scene, label in rows:
        notes.append(f"{scene}: {label}: new, not judged (--update takes it in)")
    return worse, notes


def best(rows, more):
    """The lesser times of two runs, of the methods and of the yardstick; errors are the same in both."""
    for key, row in more.items():
        if key and key in rows:
            for time in "ms", "unit":
                rows[key][time] = min(rows[key][time], row[time])
            rows[key]["cost"] = rows[key]["ms"] / rows[key]["unit"]
    return rows


def compare(build, rows):
    with open(TABLE, encoding="utf-8") as file:
        table = json.load(file)
    worse, notes = judge(rows, table)
    for _ in range(TURNS - 1):
        if not any("cost" in line for line in worse):
            break
        rows = best(rows, measure(build))
        worse, notes = judge(rows, table)
    for line in notes:
        print("note:", line)
    for line in worse:
        print("WORSE:", line)
    print(f"{len(worse)} worse" if worse else "nothing got worse")
    return 1 if worse else 0


def main(words):
    if not words or len(words) > 2 or words[1:] not in ([], ["--update"]):
        print(__doc__, file=sys.stderr)
        return 2
    rows = measure(words[0])
    if len(words) == 1:
        return compare(words[0], rows)
    for _ in range(TURNS - 1):
        rows = best(rows, measure(words[0]))
    return update(rows)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
