#!/usr/bin/env python3
"""The tables of the manual that list fields of the results file, from where the sources declare
them: each list of `field_t` in src/output stands in doc/manual.md between <!-- fields NAME --> and
<!-- end fields -->.

    doc/fields.py            names the tables that are not what the sources say
    doc/fields.py --fix      writes them
"""
import glob
import os
import re
import sys

TOP = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
MANUAL = os.path.join(TOP, 'doc', 'manual.md')
TABLE = re.compile(r'(<!-- fields (\w+) -->\n).*?(<!-- end fields -->)', re.S)
OVER = {'over_one': '', 'over_near': 'point with a facet', 'over_closed': 'closed point',
        'over_nodes': 'node', 'over_points': 'point', 'over_bodies': 'rigid body',
        'over_apex_slopes': 'contact point and parameter', 'over_contact_nodes': 'contact node',
        'over_node_slopes': 'contact node and parameter', 'over_memory': 'number'}


def arguments(text):
    """The arguments of a structure constructor, strings joined."""
    parts = re.findall(r"(?:'(?:[^']|'')*'(?:\s*//\s*)?)+|[\w%]+", text)
    return [''.join(re.findall(r"'((?:[^']|'')*)'", part)) if "'" in part else part
            for part in parts]


def sources():
    """Text of the sources, continuation lines joined."""
    paths = glob.glob(os.path.join(TOP, 'src', '*', '**', '*.f90'), recursive=True)
    for path in sorted(paths):
        with open(path, encoding='ascii') as stream:
            yield re.sub(r'&\n\s*', '', stream.read())


def declared():
    """All lists of fields: {name: [(name, components, over, unit, description, when)]}."""
    texts = list(sources())
    laws = {}
    for text in texts:
        for name, inner in re.findall(r':: (\w+) = law_state_t\((.*?)\)\n', text):
            laws[name] = dict(zip(('name', 'unit', 'description'), arguments(inner)))
    lists = {}
    for text in texts:
        for name, inner in re.findall(r':: (\w+)\(\*\) = \[ ?(field_t\(.*?\))\]\n', text, re.S):
            parts = dict(re.findall(r':: (part_\w+) = \d+ !! (.*)', text))
            rows = []
            for field in re.split(r'\), ?(?=field_t\()', inner):
                values = []
                for value in arguments(field[len('field_t('):]):
                    owner, _, component = value.partition('%')
                    law = laws.get(owner, {})
                    values.append(law.get(component, value))
                called, _, components, over, unit, description, part = values
                rows.append((called, int(components), OVER[over], unit, description, parts[part]))
            lists[name] = rows
    return lists


def table(rows):
    """A Markdown table."""
    per_point = all(row[2] == 'point' for row in rows)
    lines = ['| data set | meaning | ' + ('' if per_point else 'for each | ') +
             'numbers | unit | when |', '|---|---|' + ('' if per_point else '---|') + '---|---|---|']
    for name, components, over, unit, description, when in rows:
        shown = '–' if unit == '1' else unit.replace('force length', 'force · length').replace(
            '^2', '²')
        where = '' if per_point else f'{over} | '
        lines.append(f'| `{name}` | {description} | {where}{components} | {shown} | {when} |')
    return '\n'.join(lines) + '\n'


def renewed():
    """The manual with its tables as the sources have them; the names of lists it lacks, or that no
    source declares."""
    with open(MANUAL, encoding='utf-8') as stream:
        text = stream.read()
    lists = declared()
    strange = set(lists) ^ {name for _, name, _ in TABLE.findall(text)}
    new = TABLE.sub(lambda match: match.group(1) + '\n' + table(lists.get(match.group(2), [])) + '\n'
                    + match.group(3), text)
    return text, new, sorted(strange)


def main():
    text, new, strange = renewed()
    for name in strange:
        print(f'doc/manual.md: no source declares the list of fields {name}, or it has no table')
    if text != new and '--fix' in sys.argv[1:]:
        with open(MANUAL, 'w', encoding='utf-8') as stream:
            stream.write(new)
    elif text != new:
        print('doc/manual.md: tables of fields are not as the sources declare them; '
              'doc/fields.py --fix')
        return 1
    return 1 if strange else 0


if __name__ == '__main__':
    sys.exit(main())
