#!/usr/bin/env python3
"""Draws the diagrams of the pages in docs as docs/pictures/diagram_PAGE_N.svg, for the book.

The pages hold them as Mermaid, which mdBook shows as text. This draws the part of Mermaid that they
use with Graphviz (npm's @viz-js/viz, which needs node alone). Each picture holds the text that it
shows; tools/book.py takes those that are up to date.
"""

import argparse
import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
VIZ = "@viz-js/viz@3.31.0"
BLOCK = re.compile(r"^```mermaid\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NODE = re.compile(r"^([\w-]+)(?:\[\(?(.*?)\)?\])?$")
ARROW = re.compile(r"\s*-->\s*|\s*--\s+(.*?)\s+-->\s*")
SOURCE = re.compile(r"<metadata><!\[CDATA\[(.*?)\]\]></metadata>", re.DOTALL)
STYLE = """rankdir={direction}; compound=true; nodesep=0.3; ranksep=0.45; bgcolor="white";
node [shape=box, style="rounded,filled", fillcolor="#eef3f8", color="#5b7896", fontname="Helvetica",
fontsize=12, margin="0.12,0.06"]; edge [color="#5b7896", fontname="Helvetica", fontsize=10,
arrowsize=0.7]; graph [fontname="Helvetica", fontsize=12, style="rounded", color="#9fb3c8"];
"""
RENDER = """
const { instance } = require("@viz-js/viz");
const dots = JSON.parse(require("fs").readFileSync(0, "utf8"));
instance().then(viz => {
  const drawn = dots.map(dot => viz.renderString(dot, { format: "svg" }));
  process.stdout.write(JSON.stringify(drawn));
});
"""


def picture(page, index):
    """The picture of a page's diagram."""
    return ROOT / f"docs/pictures/diagram_{page.stem.lower()}_{index}.svg"


def source(path):
    """The diagram that a picture shows; None if there is no picture."""
    found = SOURCE.search(path.read_text()) if path.is_file() else None
    return found[1] if found else None


class Flowchart:
    """A flowchart as a Graphviz graph."""

    def __init__(self, text):
        head, *lines = [line.strip() for line in text.strip().splitlines()]
        self.direction = "LR" if head.endswith("LR") else "TB"
        self.labels, self.groups, self.edges, group = {}, {}, [], None
        for line in lines:
            if line.startswith("subgraph "):
                group, title = re.match(r"subgraph (\S+) \[(.*)\]", line).groups()
                self.groups[group] = (title, [])
            elif line == "end":
                group = None
            else:
                self.add_line(line, group)

    def add_line(self, line, group):
        """Adds the nodes and arrows of a line such as `a[A] --> b & c`."""
        parts = ARROW.split(line)
        sides = [side.split(" & ") for side in parts[::2]]
        ends = [[self.node(name.strip(), group) for name in side] for side in sides]
        for tails, label, heads in zip(ends, parts[1::2], ends[1:]):
            self.edges += [(tail, head, label or "") for tail in tails for head in heads]

    def node(self, text, group):
        """Adds a node, and returns its name."""
        name, label = NODE.match(text).groups()
        if name in self.groups:
            return name
        if label or name not in self.labels:
            self.labels[name] = label or self.labels.get(name) or name
        known = any(name in members for _, members in self.groups.values())
        if group and not known:
            self.groups[group][1].append(name)
        return name

    def dot(self):
        """The graph in Graphviz's language."""
        out = [STYLE.format(direction=self.direction)]
        out += [f'"{name}" [label="{label}"];' for name, label in self.labels.items()]
        for name, (title, members) in self.groups.items():
            inside = " ".join(f'"{member}";' for member in members)
            out.append(f'subgraph "cluster_{name}" {{ label="{title}"; {inside} }}')
        out += [self.edge(*edge) for edge in self.edges]
        return "digraph {" + "\n".join(out) + "}"

    def edge(self, tail, head, label):
        """An arrow; one between groups runs from border to border."""
        ends, attributes = [], [f'label="{label}"']
        for name, place, at in ((tail, "ltail", -1), (head, "lhead", 0)):
            if name in self.groups:
                attributes.append(f'{place}="cluster_{name}"')
                name = self.groups[name][1][at]
            ends.append(name)
        return f'"{ends[0]}" -> "{ends[1]}" [{", ".join(attributes)}];'


def state_dot(text):
    """A state diagram in Graphviz's language; arrows between the same states become one."""
    arrows = {}
    for line in text.strip().splitlines()[1:]:
        tail, head, label = re.match(r"\s*(\S+) --> (\w+)(?:: (.*))?$", line).groups()
        arrows.setdefault((tail, head), []).append(label or "")
    begin = '"[*]" [label="", shape=circle, width=0.15, fillcolor=black];'
    out = [STYLE.format(direction="TB"), begin]
    for (tail, head), labels in arrows.items():
        out.append(f'"{tail}" -> "{head}" [label="{", ".join(filter(None, labels))}"];')
    return "digraph {" + "\n".join(out) + "}"


def dot(text):
    """A diagram in Graphviz's language."""
    return state_dot(text) if text.startswith("stateDiagram") else Flowchart(text).dot()


def drawn(dots, folder):
    """The graphs as SVG."""
    folder.mkdir(parents=True, exist_ok=True)
    npm = ["npm", "install", "--silent", "--no-audit", "--prefix", str(folder), VIZ]
    subprocess.run(npm, check=True)
    node = ["node", "-e", RENDER]
    ended = subprocess.run(node, input=json.dumps(dots).encode(), cwd=folder, capture_output=True)
    ended.check_returncode()
    return json.loads(ended.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    tools = ROOT / "target/diagrams"
    parser.add_argument("--tools", type=pathlib.Path, default=tools, help="folder for npm")
    options = parser.parse_args()
    found = [
        (picture(page, index), text)
        for page in sorted((ROOT / "docs").glob("*.md"))
        for index, text in enumerate(BLOCK.findall(page.read_text()), 1)
    ]
    for (path, text), svg in zip(found, drawn([dot(text) for _, text in found], options.tools)):
        svg = svg[svg.index("<svg") :].strip()
        head, rest = svg.split(">", 1)
        path.write_text(f"{head}><metadata><![CDATA[{text}]]></metadata>{rest}\n")
        print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
