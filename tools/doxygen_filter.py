#!/usr/bin/env python3
"""A filter for doxygen: the headers' plain comments become its own. A comment in front of several
declarations that no blank line parts is the comment of each of them.

    tools/doxygen_filter.py FILE
"""
import re
import sys


def convert(text):
    out = []
    for number, paragraph in enumerate(re.split(r"\n\s*\n(?![^/]*\*/)", text)):
        lines = paragraph.split("\n")
        comment, code, inside = [], [], False
        # The comment that the paragraph begins with, and what it belongs to.
        while lines and (inside or lines[0].lstrip().startswith("/*")):
            comment.append(lines.pop(0))
            inside = "*/" not in comment[-1]
        code = lines
        head = "\n".join(comment)
        if number == 0 and head:
            head = re.sub(r"/\* (\S+\.h): ", r"/** \\file \1\n * ", head, count=1)
        elif head:
            head = re.sub(r"^(\s*)/\*", r"\1/**", head, count=1)
        body, first, depth = [], True, 0
        for line in code:
            declares = re.match(r"\s*PNB_API ", line) and depth == 0
            if declares and not first and head:
                body.append(head)
            first = first and not declares
            depth += line.count("{") - line.count("}")
            line = re.sub(r"(\S.*?[;,{}\w])(\s+)/\*(?!\*)", r"\1\2/**<", line)
            line = re.sub(r"^(\s+)/\*(?!\*)", r"\1/**", line)
            body.append(line)
        out.append("\n".join(([head] if head else []) + body))
    return "\n\n".join(out)


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        sys.stdout.write(convert(file.read()))
