#!/usr/bin/python3
"""Makes man pages and completions of shells from the help of the tools.

    tools/packaging/manuals.py TOOLS OUT

TOOLS is the folder of the built tools. OUT receives the folders of an installation's `share`: `man/man1`,
`bash-completion/completions`, `zsh/site-functions` and `fish/vendor_completions.d`.
"""

import dataclasses
import gzip
import pathlib
import re
import subprocess
import sys

COLUMN = 30  # where the help begins to describe an option


@dataclasses.dataclass
class Option:
    names: list  # none: a positional
    words: str
    default: str
    text: str

    @property
    def choices(self):
        found = re.search(r"One of ([\w, .-]+?)\.(?:$| )", self.text + " ")
        return found.group(1).split(", ") if found else []

    @property
    def is_flag(self):
        return not self.words and not self.choices

    @property
    def is_grid(self):
        return self.words.startswith("NAME") and not self.choices and re.search(r"\bgrids?\b", self.text, re.I) is not None


@dataclasses.dataclass
class Help:
    tool: str
    version: str
    summary: str
    usage: str
    sections: list  # (title, options)
    ending: list

    def options(self):
        return [option for _, options in self.sections for option in options if option.names]


def said_by(tool, option):
    return subprocess.run([tool, option], text=True, capture_output=True, check=True).stdout


def option_of(head, text):
    """An option of the help from its first columns: names, words, what CLI11 adds to them."""
    names, _, rest = head.partition(" ")
    rest = re.sub(r" ?(REQUIRED|Excludes: .*)$", "", rest)
    rest = re.sub(r":\w+ in \[[^]]*\]", "", rest)
    words, _, default = rest.partition("=")
    if not names.startswith("-"):
        return Option([], names, "", text)
    return Option(names.split(","), words.strip(), default, text)


def read_help(tool):
    lines = said_by(tool, "--help").splitlines()
    sections, ending, entry = [], [], None
    for line in lines[2:]:
        if re.fullmatch(r"[A-Z][^:]*:", line):
            sections.append((line[:-1], []))
        elif line.startswith(" " * COLUMN) and entry:
            entry[1] = f"{entry[1]} {line.strip()}".strip()
        elif re.match(r"  \S", line):
            is_short = line[COLUMN - 2:COLUMN] == "  " and len(line) > COLUMN
            entry = [line[:COLUMN].strip(), line[COLUMN:].strip()] if is_short else [line.strip(), ""]
            sections[-1][1].append(entry)
        elif line:
            ending.append(line)
    version = said_by(tool, "--version").split()[-1]
    return Help(tool.name, version, lines[0], lines[1].removeprefix("Usage: "),
                [(title, [option_of(*entry) for entry in entries]) for title, entries in sections], ending)


def roff(text):
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + escaped if escaped.startswith((".", "'")) else escaped


def man_page(manual, others):
    summary = manual.summary.rstrip(".")
    page = [f'.TH {manual.tool.upper()} 1 "" "VDBLIC {manual.version}" "VDBLIC"', ".SH NAME",
            f"{roff(manual.tool)} \\- {roff(summary[0].lower() + summary[1:])}", ".SH SYNOPSIS", f".B {roff(manual.tool)}",
            roff(manual.usage.removeprefix(manual.tool).strip()), ".SH OPTIONS"]
    for title, options in manual.sections:
        page.append(f".SS {roff(title)}")
        for option in options:
            names = ", ".join(f"\\fB{roff(name)}\\fR" for name in option.names)
            words = f"\\fI{roff(option.words)}\\fR" if option.words else ""
            default = f" By default {roff(option.default)}." if option.default else ""
            page += [".TP", f"{names} {words}".strip(), f"{roff(option.text)}{default}"]
    page += [".SH EXIT STATUS", *(roff(line) for line in manual.ending), ".SH SEE ALSO",
             ", ".join(f"\\fB{roff(other)}\\fR(1)" for other in others if other != manual.tool)]
    return "\n".join(page) + "\n"


GRIDS = r"""sed -n 's/^vdblic_info:   grid \([^ ]*\) (.*/\1/p'"""


def bash_completion(manual):
    function = f"_{manual.tool}"
    cases = []
    for option in manual.options():
        names = "|".join(option.names)
        if option.choices:
            cases.append(f'    {names}) COMPREPLY=($(compgen -W "{" ".join(option.choices)}" -- "$now")); return ;;')
        elif option.is_grid:
            cases.append(f'    {names}) COMPREPLY=($(compgen -W "$({function}_grids)" -- "$now")); return ;;')
        elif not option.is_flag:
            cases.append(f'    {names}) COMPREPLY=($(compgen -f -- "$now")); return ;;')
    names = " ".join(name for option in manual.options() for name in option.names)
    return f"""# Completion of {manual.tool}, made by tools/packaging/manuals.py.
{function}_grids() {{
    local word
    for word in "${{COMP_WORDS[@]:1}}"; do
        case $word in *.vdb) vdblic_info "${{word//[\\"\\']/}}" 2>&1 | {GRIDS}; return ;; esac
    done
}}
{function}() {{
    local now=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}
    COMPREPLY=()
    case $before in
{chr(10).join(cases)}
    esac
    case $now in
    -*) COMPREPLY=($(compgen -W "{names}" -- "$now")) ;;
    *) COMPREPLY=($(compgen -f -- "$now")) ;;
    esac
}}
complete -o filenames -F {function} {manual.tool}
"""


def quoted(text):
    return text.replace("'", "'\\''").replace("[", "(").replace("]", ")").replace(":", "\\:")


def zsh_completion(manual):
    lines = []
    for option in manual.options():
        for name in option.names:
            text = f"[{quoted(option.text)}]"
            if option.is_flag:
                lines.append(f"'{name}{text}'")
                continue
            takes = f"({' '.join(option.choices)})" if option.choices else "->grids" if option.is_grid else "_files"
            lines.append(f"'{name}{text}:{quoted(option.words.lower())}:{takes}'")
    arguments = " \\\n    ".join([*lines, "'*:file:_files'"])
    return f"""#compdef {manual.tool}
# Completion of {manual.tool}, made by tools/packaging/manuals.py.
local state line
_arguments -C \\
    {arguments}
if [[ $state = grids ]]; then
    local file=${{${{(M)words:#*.vdb}}[1]}}
    [[ -n $file ]] && compadd -- ${{(f)"$(vdblic_info ${{(Q)file}} 2>&1 | {GRIDS})"}}
fi
"""


def fish_completion(manual):
    function = f"__{manual.tool}_grids"
    lines = [f"# Completion of {manual.tool}, made by tools/packaging/manuals.py.", f"function {function}",
             "    for word in (commandline -opc)",
             f"        string match -q '*.vdb' -- $word; and vdblic_info $word 2>&1 | {GRIDS}; and return", "    end", "end"]
    for option in manual.options():
        names = " ".join(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.names)
        takes = ""
        if option.choices:
            takes = f"-x -a '{' '.join(option.choices)}' "
        elif option.is_grid:
            takes = f"-x -a '({function})' "
        elif not option.is_flag:
            takes = "-r "
        text = option.text.replace("\\", "\\\\").replace("'", "\\'")
        lines.append(f"complete -c {manual.tool} {names} {takes}-d '{text}'")
    return "\n".join(lines) + "\n"


def main():
    tools, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    manuals = [read_help(tool) for tool in sorted(tools.glob("vdblic_*")) if tool.is_file() and not tool.suffix]
    names = [manual.tool for manual in manuals]
    for manual in manuals:
        page = out / f"man/man1/{manual.tool}.1.gz"
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_bytes(gzip.compress(man_page(manual, names).encode(), mtime=0))
        for path, text in ((f"bash-completion/completions/{manual.tool}", bash_completion(manual)),
                           (f"zsh/site-functions/_{manual.tool}", zsh_completion(manual)),
                           (f"fish/vendor_completions.d/{manual.tool}.fish", fish_completion(manual))):
            (out / path).parent.mkdir(parents=True, exist_ok=True)
            (out / path).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
