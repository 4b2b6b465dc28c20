"""Pages of the documentation's site that are made of the tree: called by mkdocs, see mkdocs.yml.

The README is the first page, each stage of the guide has a page of its own, every parameter stands in a
table of the configuration's schema, and each room of the package has a page of its docstrings. Notebooks
are pages, and the gallery shows those and the examples that have a picture.
"""

import posixpath
import re
from pathlib import Path
from typing import Any

from gallery import gallery_page, notebook_page
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from speed_page import speed_page

from craftmesh.campaign.config_schema import config_schema

ROOT = Path(__file__).resolve().parents[1]
# files of the tree that are pages of the site, by their places in the tree and on the site
PAGES = {
    "README.md": "index.md",
    "config/README.md": "configuration.md",
    "benchmarks/README.md": "how-to-benchmark.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
    "SECURITY.md": "security.md",
    "examples/tutorial/README.md": "tutorial_steps.md",
}
EXAMPLES = {
    f"examples/{path.parent.name}/README.md": f"example-{path.parent.name}.md"
    for path in sorted(ROOT.glob("examples/*/README.md"))
    if path.parent.name != "tutorial"
}
PAGES |= EXAMPLES
NOTEBOOKS = {
    f"examples/notebooks/{path.name}": f"notebook-{path.stem.replace('_', '-')}.md"
    for path in sorted(ROOT.glob("examples/notebooks/*.ipynb"))
}
LINK = re.compile(r"(\]\()([^)#\s]+)((?:#[^)]*)?\))")
STAGE = re.compile(r"^## (\d+)\. ([^:\n]+): (.*)$", re.M)
ROOMS = (
    *("types", "options", "errors", "voxels", "cracks", "surface", "mesh", "sizing", "mechanics"),
    *("remeshing", "stitching", "insertion", "gradation", "tetrahedra", "assembly", "deck", "solve"),
    *("fracture", "growth", "io", "campaign", "report"),
)
SIGNS = {
    "minimum": "at least",
    "exclusiveMinimum": "above",
    "maximum": "at most",
    "exclusiveMaximum": "below",
}


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Put the pages of stages and rooms, which are made, into the navigation."""
    stages = stage_pages((ROOT / "docs/guide.md").read_text())
    made = {
        "STAGES": list(stages),
        "EXAMPLES": [*EXAMPLES.values(), *NOTEBOOKS.values()],
        "API": [f"api/{room}.md" for room in ROOMS],
    }
    for entry in config.nav or []:
        if isinstance(entry, dict):
            for name, place in entry.items():
                entry[name] = made.get(place, place) if isinstance(place, str) else place
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are made of the tree, and take away the guide, whose sections are pages."""
    made = {place: moved((ROOT / source).read_text(), source, place) for source, place in PAGES.items()}
    made |= stage_pages((ROOT / "docs/guide.md").read_text())
    made["parameters.md"] = parameters_page(config_schema())
    made["tutorial_steps.md"] += step_sections(ROOT / "examples/tutorial", made["tutorial_steps.md"])
    made["speed.md"] = speed_page(ROOT / "docs/speed.csv")
    made |= {f"api/{room}.md": room_page(room) for room in ROOMS}
    notebooks, pictures = {}, {}
    for source, place in NOTEBOOKS.items():
        notebooks[place], drawn = notebook_page(ROOT / source)
        pictures |= drawn
    made |= notebooks
    made["gallery.md"] = gallery_page(notebooks | {place: made[place] for place in EXAMPLES.values()})
    guide = files.get_file_from_path("guide.md")
    if guide is not None:
        files.remove(guide)
    for place, content in (made | pictures).items():
        files.append(File.generated(config, place, content=content))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Turn links of pages in docs/ that leave it into links on the site."""
    source = page.file.src_uri
    return markdown if page.file.generated_by else moved(markdown, f"docs/{source}", source)


def moved(text: str, source: str, place: str) -> str:
    """Return a page's text with its links as they are on the site: from the tree's `source` to `place`."""

    def link(match: re.Match) -> str:
        before, target, after = match.groups()
        if re.match(r"\w+:", target):
            return match.group()
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        if (ROOT / path).is_dir():
            path = f"{path}/README.md"
        on_site = (PAGES | NOTEBOOKS).get(path, path.removeprefix("docs/"))
        stage = re.match(r"#(\d+)-([a-z]+)-", after)
        if path == "docs/guide.md" and stage:  # its sections are pages
            on_site, after = f"stages/{int(stage[1]):02d}-{stage[2]}.md", ")"
        return before + posixpath.relpath(on_site, posixpath.dirname(place) or ".") + after

    return _deeper_lists(LINK.sub(link, text))


def _deeper_lists(text: str) -> str:
    """Return a page in which what belongs to an item of a numbered list stands four deep, for mkdocs."""
    lines, is_fenced = [], False
    for line in text.splitlines(keepends=True):
        if line.startswith("```"):
            is_fenced = not is_fenced
        lines.append(f" {line}" if line.startswith("   ") and not is_fenced else line)
    return "".join(lines)


def stage_pages(guide: str) -> dict[str, str]:
    """Return the guide as a page a stage, and the first one with what goes before and links to them."""
    heads = list(STAGE.finditer(guide))
    ends = [*(head.start() for head in heads[1:]), len(guide)]
    pages, links = {}, []
    for head, end in zip(heads, ends):
        number, verb, title = head.groups()
        place = f"stages/{int(number):02d}-{verb.split(' ')[0]}.md"
        text = f"# {verb}: {title}\n{guide[head.end() : end]}"
        pages[place] = moved(text, "docs/guide.md", place)
        links.append(f"{number}. [{verb}](stages/{posixpath.basename(place)}): {title}")
    first = moved(guide[: heads[0].start()], "docs/guide.md", "guide.md")
    return {"guide.md": f"{first}\nThe stages in their order:\n\n" + "\n".join(links) + "\n"} | pages


def step_sections(folder: Path, table: str) -> str:
    """Return a section with text and code for each step of the tutorial, in the order of its `table`."""
    sections = []
    for name in re.findall(r"^\| (t\d+) \|", table, flags=re.M):
        _, text, code = (folder / f"{name}.py").read_text().split('"""', 2)
        head, _, prose = text.partition("\n\n")
        sections.append(f"\n## {name}: {head[:-1]}\n\n{prose}\n```python\n{code.strip()}\n```\n")
    return "".join(sections)


def parameters_page(schema: dict) -> str:
    """Return the tables of all keys of the configuration: default, what is allowed, effect."""
    lines = [
        "# Every parameter",
        "",
        "The keys of the configuration; `l_min` there is `--l-min` of a subcommand.",
        "",
    ]
    plain = {key: value for key, value in schema["properties"].items() if not _keys(value)}
    lines += ["## The campaign", "", *_table(plain)]
    for name, section in schema["properties"].items():
        if _keys(section):
            lines += ["", f"## {name}", "", f"{section['description']}.", "", *_table(_keys(section))]
    return "\n".join(lines) + "\n"


def _keys(schema: dict) -> dict:
    return schema.get("properties") or (schema.get("additionalProperties") or {}).get("properties") or {}


def _table(properties: dict) -> list[str]:
    rows = ["| key | effect | default | values |", "|---|---|---|---|"]
    for key, schema in properties.items():
        default = f"`{schema['default']}`" if schema.get("default") not in ("", None) else "none"
        default = default if "default" in schema else "has to be given"
        cells = [f"`{key}`", schema.get("description", ""), default, _allowed(schema)]
        rows.append("| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |")
    return rows


def _allowed(schema: dict) -> str:
    if "enum" in schema:
        return ", ".join(f"`{value}`" for value in schema["enum"] if value is not None)
    kinds = schema.get("type", "")
    kinds = kinds if isinstance(kinds, list) else [kinds]
    limits = [f"{sign} {schema[key]}" for key, sign in SIGNS.items() if key in schema]
    return ", ".join([" or ".join(kind for kind in kinds if kind != "null"), *limits])


def room_page(room: str) -> str:
    """Return the page of a room, or module of the ground: the docstrings of its public modules."""
    folder = ROOT / "craftmesh" / room
    if not folder.is_dir():
        return f"# {room}\n\n::: craftmesh.{room}\n"
    modules = sorted(
        path for path in folder.rglob("*.py") if "kernels" not in path.parts and path.name != "__init__.py"
    )
    names = [".".join(path.relative_to(ROOT).with_suffix("").parts) for path in modules]
    return f"# {room}\n\n" + "\n".join(f"::: {name}\n" for name in names)
