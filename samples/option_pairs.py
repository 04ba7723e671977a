#!/usr/bin/env python3
"""Make the pairs of pictures of docs/methods.md and docs/render.md from what these pages say."""
import argparse
import functools
import pathlib
import re
import shlex
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGES = [ROOT / "docs/methods.md", ROOT / "docs/render.md"]
OUT = ROOT / "out" / "options"
COMMON = re.compile(r"Textures with `([^`]*)`(?:, pictures with `([^`]*)`)?[.:]")
PAIR = re.compile(r"`(-[^`]*)` or `(-[^`]*)`(?P<advects> \(of `vdblic_advect`\))?:")
PICTURE = re.compile(r"!\[[^]]*\]\((images/options/\S+\.jpg)\)")


def pairs():
    """The file of each pair with its two pictures, as options of a texture and of a picture."""
    for paragraph in "\n\n".join(page.read_text(encoding="utf-8") for page in PAGES).split("\n\n"):
        paragraph = " ".join(paragraph.split("\n"))
        if found := COMMON.match(paragraph):
            texture, picture = (shlex.split(options or "") for options in found.groups())
        elif found := PAIR.match(paragraph):
            pair = found
        elif found := PICTURE.match(paragraph):
            sides = [shlex.split(options) for options in pair.groups()[:2]]
            yield ROOT / "docs" / found[1], [
                (merged(texture, side), picture) if pair["advects"] else (texture, merged(picture, side))
                for side in sides]


def merged(*options):
    """Lists of options as one, in which the last of a name counts."""
    values = {}
    for word in sum(options, []):
        if word.startswith("--"):
            values[word] = last = []
        else:
            last.append(word)
    return [word for name, words in values.items() for word in (name, *words)]


def run(*words):
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)


@functools.cache
def texture(tools, options):
    """Make a texture, once; returns its pattern."""
    pattern = OUT / ("".join(options).replace("--", "-").lstrip("-") + ".%04d.vdb")
    run(tools / "vdblic_advect", ROOT / "samples/wake/wake.%04d.vdb", "-o", pattern, "--frames", "1-12", "--with",
        "vorticity,q", *options, "-q", "--restart")
    return pattern


def main():
    made = {target.stem: (target, sides) for target, sides in pairs()}
    parser = argparse.ArgumentParser(description=__doc__ + " Needs ffmpeg.")
    parser.add_argument("tools", type=pathlib.Path, help="folder of the built tools")
    parser.add_argument("names", nargs="*", metavar="name", help="pictures without their ending; by default all")
    given = parser.parse_args()
    if unknown := [name for name in given.names if name not in made]:
        parser.error(f"no page has the picture {unknown[0]}; these exist: {', '.join(made)}")
    OUT.mkdir(parents=True, exist_ok=True)
    for target, sides in [made[name] for name in given.names or made]:
        target.parent.mkdir(parents=True, exist_ok=True)
        images, tools = [], given.tools.resolve()
        for side, (advects, renders) in zip(("left", "right"), sides):
            images.append(OUT / f"{target.stem}-{side}.png")
            frames = texture(tools, tuple(advects))
            run(tools / "vdblic_render", frames, "-o", images[-1], "--frames", 12, "--size", 640, 400, *merged(
                ["--samples", "4", "--solid", "domain"], renders), "-q")
        run("ffmpeg", "-loglevel", "error", "-y", "-i", images[0], "-i", images[1], "-filter_complex",
            "[0]pad=iw+8:ih:0:0:white[left];[left][1]hstack", "-q:v", 3, target)
        print(target.relative_to(ROOT))


if __name__ == "__main__":
    main()
