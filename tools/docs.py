#!/usr/bin/env python3
"""Keeps the documents true: fills in what the program knows, looks for dead links, checks that
public things are explained, makes the API reference.

    tools/docs.py fill BUILD       rewrite the generated blocks of the Markdown files
    tools/docs.py check            links, and comments of the headers; prints what is wrong
    tools/docs.py api FOLDER       the API reference as HTML (doxygen) into FOLDER/api
    tools/docs.py measured REPORT  takes a report.json of 'penumbra bench all' into
                                   docs/measured.json; scenes and methods that it lacks keep theirs

Generated blocks stand between <!-- penumbra: KIND WORD... --> and <!-- end -->:

    params METHOD    the method's parameters, from the registry
    can METHOD       lights, receivers, processor, paper, from the registry
    figures METHOD   its errors and cost on the built-in scenes, from docs/measured.json
    methods          every method with its mean error and cost, from both
"""
import json
import math
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MEASURED = os.path.join(ROOT, "docs", "measured.json")
COST = ("Cost is the number of shadow rays per pixel that the reference traces in the same time, "
        "measured in the same run (some 100 to 200 million rays a second and processor core when the "
        "machine is quiet).")


def markdown_files():
    for folder, folders, names in os.walk(ROOT):
        folders[:] = sorted(f for f in folders if not f.startswith((".", "build", "demo")))
        for name in sorted(names):
            if name.endswith(".md"):
                yield os.path.join(folder, name)


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


# ---- generated blocks ----


def run_json(build, *words):
    program = os.path.join(ROOT, build, "penumbra")
    return json.loads(subprocess.run([program, *words, "--json"], check=True, text=True,
                                     stdout=subprocess.PIPE).stdout)


def cell(text):
    return str(text).replace("|", "\\|").replace("\n", " ")


def block_params(method):
    if not method["parameters"]:
        return "It has no parameters of its own.\n"
    rows = ["| `-p` | default | values | what |", "| --- | --- | --- | --- |"]
    for p in method["parameters"]:
        values = p["type"]
        if p.get("choices"):
            values = ", ".join(f"`{v}`" for v in p["choices"].split("|"))
        elif p["type"] in ("integer", "number"):
            values = f"{p.get('minimum', 0):g} to {p.get('maximum', 0):g}"
        default = f"`{p['default']}`" if p["default"] else ""
        rows.append(f"| `{p['key']}` | {default} | {cell(values)} | {cell(p['summary'])} |")
    return "\n".join(rows) + "\n"


def block_can(method):
    rows = ["| | |", "| --- | --- |",
            f"| lights | {', '.join(method['lights'])} |",
            f"| receivers | {method['receivers']} |",
            f"| runs on | {method['processor']} |"]
    if method.get("samples"):
        rows.append(f"| light samples (`-n`) | {method['samples']} unless told otherwise |")
    if method.get("paper"):
        rows.append(f"| paper | {cell(method['paper'])} |")
    return "\n".join(rows) + "\n"


def short(value):
    return f"{value:,.0f}" if value >= 99.5 else f"{value:.0f}" if value >= 9.95 else f"{value:.2g}"


def machine(measured):
    opengl = f", OpenGL on {measured['devices'][0]}" if measured["devices"] else ""
    return (f"{measured['processor']}, {measured['threads']} threads{opengl}, {measured['width']}x"
            f"{measured['height']}, {measured['date'][:10]}")


def block_figures(name, measured):
    rows = ["| scene | light | cost | RMSE | mean | 99 % below | umbra leak | lit darkening |",
            "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for scene in measured["scenes"]:
        row = scene["methods"].get(name)
        if not row:
            continue
        rows.append(f"| {scene['scene']} | {scene['light']} | {short(row['rays'])} | {row['rmse']:.4f} | "
                    f"{row['mean']:+.4f} | {row['p99']:.4f} | {100 * row['leak']:.2f} % | "
                    f"{100 * row['dark']:.2f} % |")
    if len(rows) == 2:
        return "Not measured yet: `make measure`.\n"
    truth = min(s["methods"][name].get("truth", 4096) for s in measured["scenes"]
                if name in s["methods"])
    return (f"Against {truth:,} ray-traced samples per pixel, defaults "
            f"({machine(measured)}; `penumbra bench all -o DIR`). {COST}\n\n" + "\n".join(rows) +
            "\n")


def geometric(values):
    return math.exp(sum(math.log(v) for v in values) / len(values)) if values else math.nan


def block_methods(methods, measured):
    rows = ["| method | what it does | lights | receivers | runs on | cost | RMSE | leak | scenes |",
            "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for m in methods:
        found = [s["methods"][m["name"]] for s in measured["scenes"] if m["name"] in s["methods"]]
        lights = "all" if len(m["lights"]) == 6 else ", ".join(m["lights"])
        if len(m["lights"]) == 5:
            missing = [t for t in ("rectangle", "disk", "polygon", "line", "point", "sun")
                       if t not in m["lights"]]
            lights = f"all but {missing[0]}"
        figures = "| | | | |"
        if found:
            figures = (f"| {short(geometric([max(r['rays'], 1e-2) for r in found]))} | "
                       f"{geometric([max(r['rmse'], 1e-5) for r in found]):.4f} | "
                       f"{100 * sum(r['leak'] for r in found) / len(found):.1f} % | {len(found)} |")
        page = f"docs/{m['name']}.md"
        if not os.path.exists(os.path.join(ROOT, page)):
            page = f"docs/{m['name'].split('-')[0]}.md"
        name = f"`{m['name']}`"
        if os.path.exists(os.path.join(ROOT, page)):
            name = f"[{name}]({page})"
        what = m["summary"].split(". ")[0].rstrip(".")
        rows.append(f"| {name} | {cell(what)} | {lights} | {m['receivers']} | "
                    f"{m['processor']} {figures}")
    return ("\n".join(rows) + "\n\n" +
            f"Means over the built-in scenes that were measured (cost and RMSE geometric, umbra leak "
            f"arithmetic), default settings, {machine(measured)}. {COST} `penumbra bench all -o DIR` "
            f"prints the rows.\n")


def fill(build):
    methods = run_json(build, "methods")["methods"]
    by_name = {m["name"]: m for m in methods}
    measured = json.loads(read(MEASURED)) if os.path.exists(MEASURED) else None
    pattern = re.compile(r"(<!-- penumbra: (\w+) ?([\w:=.-]*) -->\n)(.*?)(<!-- end -->)", re.S)

    def block(match):
        kind, name = match.group(2), match.group(3)
        text = match.group(4)
        if kind == "params" and name in by_name:
            text = block_params(by_name[name])
        elif kind == "can" and name in by_name:
            text = block_can(by_name[name])
        elif kind == "figures" and measured:
            text = block_figures(name, measured)
        elif kind == "methods" and measured:
            text = block_methods(methods, measured)
        return match.group(1) + text + match.group(5)

    for path in markdown_files():
        old = read(path)
        new = pattern.sub(block, old)
        if new != old:
            with open(path, "w", encoding="utf-8") as file:
                file.write(new)
            print("filled in", os.path.relpath(path, ROOT))


def reduce_report(path):
    report = json.loads(read(path))
    scenes, gone = [], {}
    for scene in report["scenes"]:
        rows = {}
        ray = scene["truth"]["milliseconds"] / scene["truth"]["samples"]
        for m in scene["methods"]:
            if m["milliseconds"] is None or not m["pixels"]:
                continue
            rows[m["label"]] = {"ms": round(m["milliseconds"], 3),
                                "rays": float(f"{m['milliseconds'] / ray:.3g}"), "rmse": round(m["rmse"], 5),
                                "mean": round(m["mean_error"], 5), "p99": round(m["p99_error"], 5),
                                "leak": round(m["umbra_leak"], 5),
                                "dark": round(m["lit_darkening"], 5),
                                "truth": scene["truth"]["samples"]}
        gone[scene["scene"].removeprefix("builtin:")] = {
            note.split(" is left out")[0] for note in scene["notes"] if " is left out" in note}
        scenes.append({"scene": scene["scene"].removeprefix("builtin:"),
                       "light": scene["light_type"], "triangles": scene["triangles"],
                       "methods": rows})
    first = report["scenes"][0]
    devices = sorted({m["device"] for s in report["scenes"] for m in s["methods"]
                      if m.get("device")} - {report["processor"]})
    # Methods that this report lacks keep what was measured before, but for those that it left out.
    if os.path.exists(MEASURED):
        before = json.loads(read(MEASURED))
        old = {s["scene"]: s["methods"] for s in before["scenes"]}
        for scene in scenes:
            kept = {label: row for label, row in old.get(scene["scene"], {}).items()
                    if label not in gone[scene["scene"]]}
            scene["methods"] = {**kept, **scene["methods"]}
        scenes = [next((n for n in scenes if n["scene"] == s["scene"]), s)
                  for s in before["scenes"]] + [s for s in scenes if s["scene"] not in old]
    measured = {"date": report["date"], "processor": report["processor"], "devices": devices,
                "threads": report["threads"], "width": first["width"], "height": first["height"],
                "scenes": scenes}
    text = json.dumps(measured, indent=1)
    text = re.sub(r"\{\s+(\"ms\"[^}]*?)\s+\}", lambda m: "{" + " ".join(m.group(1).split()) + "}", text)
    with open(MEASURED, "w", encoding="utf-8") as file:
        file.write(text + "\n")


# ---- checks ----


def slug(heading):
    """As GitHub makes anchors of headings."""
    text = re.sub(r"[`*_]|\[|\]\([^)]*\)", "", heading.strip().lower())
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def anchors(path):
    text = re.sub(r"```.*?```", "", read(path), flags=re.S)
    return {slug(h) for h in re.findall(r"^#+ (.*)$", text, re.M)} | set(
        re.findall(r"<a (?:id|name)=\"([^\"]+)\"", text))


def check_links():
    wrong = []
    for path in markdown_files():
        text = re.sub(r"```.*?```", "", read(path), flags=re.S)
        text = re.sub(r"`[^`\n]*`", "", text)
        for target in re.findall(r"\]\(([^)\s]+)(?: \"[^\"]*\")?\)", text):
            if re.match(r"[a-z]+:", target):
                continue
            name, _, anchor = target.partition("#")
            file = os.path.normpath(os.path.join(os.path.dirname(path), name)) if name else path
            where = f"{os.path.relpath(path, ROOT)}: {target}"
            if not os.path.exists(file):
                wrong.append(f"{where}: there is no such file")
            elif anchor and file.endswith(".md") and anchor not in anchors(file):
                wrong.append(f"{where}: there is no such heading")
        for name in re.findall(r"(?:src|href)=\"([^\"#:]+)\"", text):
            if not os.path.exists(os.path.join(os.path.dirname(path), name)):
                wrong.append(f"{os.path.relpath(path, ROOT)}: {name}: there is no such file")
    return wrong


def check_headers():
    """Every public function and type stands in a paragraph that a comment opens or explains."""
    wrong = []
    folder = os.path.join(ROOT, "include", "penumbra")
    for name in sorted(os.listdir(folder)):
        if not name.endswith(".h"):
            continue
        text = read(os.path.join(folder, name))
        if not text.startswith("/* " + name + ": "):
            wrong.append(f"include/penumbra/{name}: does not open with what it is about")
        for match in re.finditer(r"^(?:PNB_API [^;]*?\b(pnb_\w+)\(|typedef (?:struct|enum) (\w+))",
                                 text, re.M):
            before = text[:match.start()].rstrip(" ")
            paragraph = before[before.rfind("\n\n") + 1:]
            line = text[match.start():text.find("\n", match.start())]
            thing = match.group(1) or match.group(2)
            plain = re.match(r"typedef \w+ (\w+) \1;", line)
            explained = "/*" in paragraph or "*/" in paragraph or "/*" in line or plain
            body = text[match.start():text.find("} " + str(thing) + ";", match.start())]
            if match.group(2) and "{" in line and "/*" in body:
                explained = True
            if not explained and not named_well(thing):
                wrong.append(f"include/penumbra/{name}: {thing} has no comment")
    return wrong


def named_well(thing):
    """Pairs and counts whose name says it all."""
    return thing.endswith(("_destroy", "_finish", "_count", "_create")) or thing in SELF_EXPLAINING


SELF_EXPLAINING = {"pnb_scene_set_ambient", "pnb_scene_set_background", "pnb_log_level"}


def check():
    wrong = check_links() + check_headers()
    for line in wrong:
        print(line)
    print(f"{len(wrong)} wrong" if wrong else "links and headers are in order")
    return 1 if wrong else 0


def api(folder):
    settings = read(os.path.join(ROOT, "docs", "Doxyfile"))
    version = re.search(r"version: '([^']+)'", read(os.path.join(ROOT, "meson.build"))).group(1)
    os.makedirs(folder, exist_ok=True)
    settings += f"\nPROJECT_NUMBER = {version}\nOUTPUT_DIRECTORY = \"{os.path.abspath(folder)}\"\n"
    return subprocess.run(["doxygen", "-"], input=settings, text=True, cwd=ROOT).returncode


def main(words):
    if words[:1] == ["fill"] and len(words) == 2:
        return fill(words[1])
    if words == ["check"]:
        return check()
    if words[:1] == ["api"] and len(words) == 2:
        return api(words[1])
    if words[:1] == ["measured"] and len(words) == 2:
        return reduce_report(words[1])
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
