"""The truck: what it is made of, how it moves, and what it may do to a pallet; each number with where it is from.

All of them were set before the simulation was first compared with the swept-volume check, and none was changed after,
but for ``lowest``: without it an estimate that is pitched up sent the heels through the floor.
"""

from dataclasses import dataclass, field

from warehouse_sim.evaluation.docking.fork import FORK


@dataclass(frozen=True)
class Truck:
    """A level truck with forks on a carriage, and the limits that make a docking fail."""

    fork: dict[str, float] = field(default_factory=lambda: dict(FORK))
    """Tines of 100 x 40 x 1150 mm (ISO 2330, class 2A), heel 5 cm before the estimated face: as the swept-volume check
    has."""
    tip_thickness: float = 0.012
    """Of the tines at their tips (m); their underside rises to it over the last quarter, as the catalog draws forks.
    ISO 2330 leaves the tip to the maker: an assumption."""
    shank_height: float = 0.60
    """Of the upright arm of a fork over the underside of its blade (m), as the catalog has it."""
    backrest_width: float = 1.0
    """Of carriage and load backrest (m), as the catalog's counterbalance truck has it."""
    backrest_height: float = 1.19
    """Top of the load backrest over the tines (m), as the catalog has it."""
    truck_mass: float = 2500.0
    """Kilograms that drive: of the order of a 1.6 t truck's, an assumption."""
    carriage_mass: float = 210.0
    """Kilograms of carriage and forks: an assumption (two forks of 35 kg, 140 kg of carriage and backrest)."""
    side_play: float = 0.001
    """The forks hang up to this to either side of where they are sent (m); where is drawn for each pose. A
    sideshifter's
    bearings and hooks have 1-2 mm of clearance when set right (Cascade, K-Series sideshifter, installation): its
    greater end over both sides. That it is as loose sideways as at the bearings is an assumption."""
    tilt_play: float = 0.0049
    """Angle by which the tips can be pushed up before the carriage resists (rad): 2 mm of clearance at the lower hook
    (as above) over the 407 mm between the bars of a class 2 carriage (ISO 2328). Empty forks rest at its lower end,
    which is how a truck is measured in; so it costs no clearance below and gives way above."""
    speed: float = 0.2
    """Of insertion (m/s): NISTIR 8140 (2016) drove all precise dockings at 0.2 m/s or less."""
    lift_speed: float = 0.1
    """Of the lift under load (m/s): an assumption, a fifth to a quarter of such a truck's fastest."""
    start_gap: float = 0.10
    """From the tips to the nearest point of the pallet at the start (m): an assumption, long enough to get up to
    speed."""
    raised: float = 0.05
    """How high the pallet is lifted to prove that it was taken (m): EN 15620 leaves 75 mm over a load in a rack."""
    max_lift: float = 0.25
    """The lift gives up after this way (m): an assumption, more than the height of any pocket."""
    lowest: float = 0.010
    """The lift goes no lower than with the undersides of the heels this far over the floor (m): an assumption; lowered
    blades of 40 mm have their tops at 50-60 mm (h13 of makers' type sheets, VDI 2198)."""
    max_tilt: tuple[float, float] = (-0.0873, 0.1396)
    """Pitch that the mast can take (rad): 5 degrees forward, 8 back, usual of such trucks, without a source."""
    friction_steel: float = 0.3
    """Of pallets on forks, rack beams and all else of steel: sawn wood on steel sheet, CTU Code, informative
    material 5."""
    friction_floor: float = 0.55
    """Of pallets on the floor: smooth concrete on sawn wood, as above."""
    friction_load: float = 0.5
    """Of a load on its pallet: cardboard on a wooden pallet, as above."""
    max_force: float = 750.0
    """Force (N) that the forks may exert on anything while they go in. No source was found: an assumption, of the order
    at which an obstacle stops an automated truck, five times what slides an empty EPAL 1 and a fifth of what slides a
    loaded one."""
    force_time: float = 0.05
    """The force is its mean over this time (s), so that the first touch of two stiff bodies counts by its momentum and
    not by the stiffness of the contact: an assumption."""
    max_push: float = 0.010
    """How far any corner of the pallet may move while the forks go in (m): set by the benchmark's definition, 1 cm."""
    max_lean: float = 0.0873
    """Tilt of the lifted pallet against how it stood (rad) beyond which it is falling: an assumption, 5 degrees."""
    max_slip: float = 0.05
    """How far the load may slip on the pallet, or the pallet on the forks (m), before it counts as falling: an
    assumption."""


TRUCK = Truck()
