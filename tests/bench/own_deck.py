"""mfec: its deck from a scene. The mesh is the file that CalculiX reads, too."""


def deck(scene, limit=0):
    """The deck; it reads mesh.inp. Only tables are written, and contact where it is judged. With a
    limit: only that many increments of the first phase."""
    text = [f'MFEC * * {scene.name} {scene.size:g}\n\nMESH mesh.inp\n\n',
            f'MATErial 1\n  SOLId {scene.law}\n'
            f'  ELAStic ISOTropic {scene.young!r} {scene.poisson!r}\n\n']
    text.append('BOUNdary\n' + ''.join(
        f'  {name} ' + ' '.join('1' if i in directions else '0' for i in (1, 2, 3)) + '\n'
        for name, directions in scene.fixed.items()) + '\n')
    text += [displacements(scene), forces(scene)]
    if scene.contact:
        text.append(pair(scene.contact))
    fields = 'contact' if scene.contact and scene.known.get('pressure') else 'NONE'
    shown = ''
    if scene.shown:
        shown = f'  HISTory NODE {scene.mesh.node_sets[scene.shown[0]][0]} {scene.shown[1]}\n'
    reactions = f'  REACtions {scene.watched}\n' if scene.watched else ''
    text.append(f'OUTPut\n{reactions}  FIELds {fields}\n  STATe NONE\n{shown}\nEND\nBATCh\n')
    for n in scene.increments[:1] if limit else scene.increments:
        text.append(f'  DT,,1/{n}\n  STEP,,{limit or n}\n')
    return ''.join(text) + 'END\nSTOP\n'


def displacements(scene):
    """DISPlacement, the proportional loads of each degree of freedom, and their tables."""
    histories = sorted({factors for _, _, _, factors in scene.moved})
    values, loads = {}, {}
    for name, i, value, factors in scene.moved:
        values.setdefault(name, [0.0]*3)[i - 1] = value
        loads.setdefault(name, [1]*3)[i - 1] = histories.index(factors) + 1
    text = 'DISPlacement\n' + ''.join(record(name, v) for name, v in values.items()) + '\n'
    if any(n != [1]*3 for n in loads.values()):
        text += 'FPROportional\n' + ''.join(record(name, n) for name, n in loads.items()) + '\n'
    for number, factors in enumerate(histories or [(1,)*scene.phases()], 1):
        text += f'PROPortional {number}\n  0 0\n' + ''.join(
            f'  {time} {factor!r}\n' for time, factor in enumerate(factors, 1)) + '\n'
    return text if scene.moved else text[text.index('PROP'):]


def forces(scene):
    """FORCe."""
    if not scene.forces:
        return ''
    return 'FORCe\n' + ''.join(record(node, f) for node, f in scene.forces.items()) + '\n'


def record(name, values):
    """One record of a set or of a node (whose second item is an increment)."""
    start = f'  {name}' if isinstance(name, str) else f'  {name} 0'
    return start + ' ' + ' '.join(repr(v) for v in values) + '\n'


def pair(contact):
    """CONTact."""
    friction = f'    FRICtion COULomb {contact.friction!r}\n' if contact.friction else ''
    method = f'{contact.own_method} {contact.slave} {contact.master}'
    if contact.own_method == 'SEGMent':
        method = f'GTOS {contact.slave} {contact.master} SEGMent'
    elif contact.own_method[:4] == 'GTOS':
        method = f'GTOS {contact.slave} {contact.master}{contact.own_method[4:]}'
    penalty = '' if contact.own_method == 'MORTar' else f'    PENAlty AREA {contact.penalty!r}\n'
    return f'CONTact\n  PAIR 1 pair\n    {method}\n{penalty}{friction}\n'
