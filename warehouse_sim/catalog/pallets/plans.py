"""The block pallets of the catalog as plans.

EPAL publishes for each type the size, the weight and how many boards, blocks and nails it has (epal-pallets.org, pages
"Load carriers"); it names a pallet by the length of its stringer boards times that of its deck boards, which says which
way they run. In the object frame x runs along the longer edge, whatever the name.

What is not in those pages is marked *derived* (it follows from published numbers) or *unverified* (a plausible value;
change the plan with ``dataclasses.replace`` where a better one is known).
"""

from warehouse_sim.catalog.pallets.block_pallet import BlockPallet

_WIDE, _NARROW = 0.145, 0.100

EPAL1 = BlockPallet(
    obj_id=1,
    along=1.2,
    across=0.8,
    mass=25.0,
    deck=(_WIDE, _NARROW, _WIDE, _NARROW, _WIDE),
    lanes=(_NARROW, _WIDE),
    columns=(_WIDE, _WIDE),
    block=0.078,
)
"""800 x 1200 x 144 mm: 11 boards, 9 blocks, about 25 kg (EPAL); every piece is in the parts list of UIC 435-2."""

EPAL2 = BlockPallet(
    obj_id=2,
    along=1.0,
    across=1.2,
    mass=35.0,
    deck=(_WIDE, _NARROW, _NARROW, _NARROW, _WIDE, _NARROW, _NARROW, _NARROW, _WIDE),
    lanes=(_WIDE, _WIDE),
    columns=(_NARROW, _WIDE),
    block=0.096,
    base="perimeter",
    deck_along="y",
)
"""1200 x 1000 x 162 mm on a base frame: 17 boards, 9 blocks, about 35 kg (EPAL).

Derived: 9 deck boards, 3 stringer boards and 5 in the base; blocks of 96 mm, for 162 mm with boards of 22 mm. Their
volume at the density of EPAL 1 (553 kg/m^3) gives 33 kg. Unverified: the widths, which are those of EPAL 1.
"""

EPAL3 = BlockPallet(
    obj_id=3,
    along=1.2,
    across=1.0,
    mass=30.0,
    deck=(_WIDE, _NARROW, _NARROW, _WIDE, _NARROW, _NARROW, _WIDE),
    lanes=(_NARROW, _WIDE),
    columns=(_WIDE, _WIDE),
    block=0.078,
)
"""1000 x 1200 x 144 mm: 13 boards, 9 blocks, about 30 kg (EPAL).

Derived: 7 deck boards, 3 stringer boards, 3 skids; wide, two narrow, wide, two narrow, wide is the order on the Finnish
1000 x 1200 pallet (ooo-specproekt.ru). Their volume at the density of EPAL 1 gives 29 kg.
"""

EPAL6 = BlockPallet(
    obj_id=4,
    along=0.6,
    across=0.8,
    mass=9.5,
    deck=(0.08,) * 7,
    lanes=(0.10, 0.10),
    columns=(0.025, 0.10),
    block=0.081,
    board=0.021,
    stringer_widths=(0.075, 0.10),
    brackets=True,
    deck_along="y",
)
"""800 x 600 x 144 mm half pallet: 7 deck boards, 6 stringer and base boards, all 21 mm, six 3 mm steel brackets, less
than 10 kg (EPAL's announcement, woodworkingnetwork.com, verkehrsrundschau.de); 9.5 kg (ashcco.com).

Derived: uprights of 81 mm. The brackets are 25 mm deep, so that 550 mm are free between them on the 600 mm face as
stand.no 142 asks of half pallets. Unverified: the other widths.
"""

EPAL7 = BlockPallet(
    obj_id=5,
    along=0.8,
    across=0.6,
    mass=10.5,
    deck=(0.095,) * 5,
    lanes=(0.025, 0.10),
    columns=(0.10, 0.10),
    block=0.097,
    base_widths=(0.075, 0.10),
    brackets=True,
)
"""600 x 800 x 163 mm half pallet (Duesseldorfer), wood with steel brackets.

Derived: uprights of 97 mm with boards of 22 mm; 550 mm between the brackets and windows of 90-140 mm as stand.no 142
asks of half pallets. Unverified: number and widths of the boards; the mass is that of their volume.
"""

BLUE_BLOCK = BlockPallet(
    obj_id=7,
    along=1.0,
    across=1.2,
    mass=29.0,
    deck=(0.14,) * 7,
    lanes=(0.16, 0.16),
    columns=(0.127, 0.127),
    block=0.099,
    board=0.021,
    base="perimeter",
    deck_along="y",
    make="POOL",
)
"""1200 x 1000 x 162 mm pool pallet, painted blue, on a full perimeter base.

Its maker publishes a drawing for the North American size only (global.chep.com, "Pooled Wood Block Pallet": 1219 x 1016
x 141 mm, windows 370 x 90 mm on the 1219 mm face and 318 x 106 mm on the 1016 mm face). Derived from that: stringer
boards run along the long face and make its windows lower by a board; blocks are 160 mm long and 127 mm wide.
Unverified: thickness of the boards, which sets the windows' height, and the mass.
"""
