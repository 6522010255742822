"""Seeds of the scenes that `tests/stress/run` and `tests/ablate` have in common."""

# Realistic scenes of the ordinary run: small ones, of each family.
QUICK_REALISTIC = (5, 8, 13, 17, 21, 25, 66, 67, 71, 82, 88, 93, 94, 7002, 13139, 14019, 14199,
                   60199, 97299, 97339, 100049)

# Bodies that fall (`drops.py`): scenes that the condensed form alone did not carry to their end
# (without friction, onto ten-node floors: 91, 226), and others of each kind.
DROP_SEEDS = (3, 9, 12, 20, 22, 27, 38, 91, 226)

# With MORTar: candidates of contact change between rounds, which has read beyond an array (7430); a
# body without loads lies with gaps of round-off, which has held it as stiffly as a node (91208); one
# that tips over has gone 17,000 of its sizes in one step (41314); a plate that slides between two
# bodies (41880: 872 cuts); all slips at first where a push is new (52036: 265 cuts).
MORTAR_SEEDS = (7430, 41314, 41880, 52036, 91208)
