"""Sections of the benchmark's document that are renewed one by one."""


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
