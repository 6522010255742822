"""Pages that a script makes: what it says against what stands there."""


def is_old(path, text, fix):
    """The file is not there, or has another text; written with fix."""
    try:
        with open(path, encoding='utf-8') as stream:
            old = stream.read()
    except FileNotFoundError:
        old = ''
    if old != text and fix:
        with open(path, 'w', encoding='utf-8') as stream:
            stream.write(text)
    return old != text
