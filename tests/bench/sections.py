"""Sections of the benchmark's document that are renewed one by one, and the lines kept for them."""
import csv
import os


def read(path, key):
    """The lines kept in a file, by what `key` makes of each."""
    if not os.path.exists(path):
        return {}
    with open(path, encoding='utf-8', newline='') as stream:
        return {key(line): line for line in csv.DictReader(stream)}


def keep(path, columns, lines):
    """Writes lines; numbers with four digits."""
    with open(path, 'w', encoding='utf-8', newline='') as stream:
        writer = csv.DictWriter(stream, columns, lineterminator='\n')
        writer.writeheader()
        for line in lines:
            writer.writerow({k: f'{v:.4g}' if isinstance(v, float) else v
                             for k, v in line.items()})


def renew(document, start, follower, section):
    """Puts a section, which begins with its title, in the place of the one before, or before the
    section that follows it."""
    with open(document, encoding='utf-8') as stream:
        text = stream.read()
    before, found, rest = text.partition(start + '\n')
    if found:
        rest = rest[rest.index('\n## ') + 1:] if '\n## ' in rest else ''
    else:
        before, _, rest = text.partition(follower + '\n')
        rest = follower + '\n' + rest
    with open(document, 'w', encoding='utf-8') as stream:
        stream.write(before + section + rest)
