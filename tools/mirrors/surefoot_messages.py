"""The messages of Surefoot for ctypes. Generated from shared-types/src/message; see shared-types/tests/mirrors.rs.

The classes fit the `iceoryx2` package: `type_name()` is the name under which a service knows them. A service of
Surefoot carries the attribute `surefoot.layout`, whose value must be the message's LAYOUT.
"""

import ctypes

JOINTS_MAX = 48
CHUNK_WAYPOINTS_MAX = 32
CONTACTS_MAX = 4
POLYGON_VERTICES_MAX = 16
CORRECTIONS_MAX = 32

Digest = ctypes.c_uint8 * 32


class Waypoint(ctypes.Structure):
    LAYOUT = "692f60eacc1a6302"
    _fields_ = [
        ("time", ctypes.c_double),
        ("root_position", ctypes.c_double * 3),
        ("root_rotation", ctypes.c_double * 4),
        ("q", ctypes.c_double * JOINTS_MAX),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.Waypoint.v1"


class Contact(ctypes.Structure):
    LAYOUT = "93de07947c76db00"
    _fields_ = [
        ("limb", ctypes.c_uint32),
        ("polygon_len", ctypes.c_uint32),
        ("position", ctypes.c_double * 3),
        ("rotation", ctypes.c_double * 4),
        ("polygon", (ctypes.c_double * 2) * POLYGON_VERTICES_MAX),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.Contact.v1"


class PlanChunk(ctypes.Structure):
    LAYOUT = "090b3ef386060954"
    _fields_ = [
        ("schema", ctypes.c_uint64),
        ("session", ctypes.c_uint64),
        ("target_controller", ctypes.c_uint64),
        ("plan_id", ctypes.c_uint64),
        ("epoch", ctypes.c_uint64),
        ("sequence", ctypes.c_uint64),
        ("flags", ctypes.c_uint32),
        ("mode", ctypes.c_uint32),
        ("contacts_len", ctypes.c_uint32),
        ("waypoints_len", ctypes.c_uint32),
        ("joints_len", ctypes.c_uint32),
        ("crc", ctypes.c_uint32),
        ("robot", Digest),
        ("world", Digest),
        ("config", Digest),
        ("stream", Digest),
        ("contacts", Contact * CONTACTS_MAX),
        ("waypoints", Waypoint * CHUNK_WAYPOINTS_MAX),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.PlanChunk.v1"


class Margins(ctypes.Structure):
    LAYOUT = "babb94a9813dc304"
    _fields_ = [
        ("limits", ctypes.c_double),
        ("contact", ctypes.c_double),
        ("balance", ctypes.c_double),
        ("collision", ctypes.c_double),
        ("self_collision", ctypes.c_double),
        ("torque", ctypes.c_double),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.Margins.v1"


class Standing(ctypes.Structure):
    LAYOUT = "7bcc833a9657f302"
    _fields_ = [
        ("mode", ctypes.c_uint32),
        ("contacts_len", ctypes.c_uint32),
        ("waypoint", Waypoint),
        ("contacts", Contact * CONTACTS_MAX),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.Standing.v1"


class Correction(ctypes.Structure):
    LAYOUT = "a26bc66974604ab1"
    _fields_ = [
        ("kind", ctypes.c_uint32),
        ("shape", ctypes.c_uint32),
        ("position", ctypes.c_double * 3),
        ("rotation", ctypes.c_double * 4),
        ("half_extents", ctypes.c_double * 3),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.Correction.v1"


class Feedback(ctypes.Structure):
    LAYOUT = "220534f1332201cb"
    _fields_ = [
        ("schema", ctypes.c_uint64),
        ("instance", ctypes.c_uint64),
        ("session", ctypes.c_uint64),
        ("plan_id", ctypes.c_uint64),
        ("epoch", ctypes.c_uint64),
        ("next_sequence", ctypes.c_uint64),
        ("count", ctypes.c_uint64),
        ("verdict", ctypes.c_uint32),
        ("check", ctypes.c_uint32),
        ("refused_sequence", ctypes.c_uint64),
        ("refused_waypoint", ctypes.c_uint32),
        ("finished", ctypes.c_uint32),
        ("duplicated", ctypes.c_uint64),
        ("gaps", ctypes.c_uint64),
        ("walked", ctypes.c_uint64),
        ("busy", ctypes.c_uint32),
        ("corrections_len", ctypes.c_uint32),
        ("reserved", ctypes.c_uint32),
        ("crc", ctypes.c_uint32),
        ("stream", Digest),
        ("margins", Margins),
        ("standing", Standing),
        ("corrections", Correction * CORRECTIONS_MAX),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.Feedback.v1"


class StancePoseData(ctypes.Structure):
    LAYOUT = "4a02cea3b49035ee"
    _fields_ = [
        ("position", ctypes.c_double * 3),
        ("yaw", ctypes.c_double),
        ("stance_width", ctypes.c_double),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.StancePoseData.v1"


class PlanRequest(ctypes.Structure):
    LAYOUT = "04a8430304f257d9"
    _fields_ = [
        ("schema", ctypes.c_uint64),
        ("client", ctypes.c_uint64),
        ("number", ctypes.c_uint64),
        ("seed", ctypes.c_uint64),
        ("work_max", ctypes.c_uint64),
        ("kind", ctypes.c_uint32),
        ("crc", ctypes.c_uint32),
        ("start", StancePoseData),
        ("goal", StancePoseData),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.PlanRequest.v1"


class PlanStatus(ctypes.Structure):
    LAYOUT = "9c54fee5c01ea6ee"
    _fields_ = [
        ("schema", ctypes.c_uint64),
        ("session", ctypes.c_uint64),
        ("client", ctypes.c_uint64),
        ("number", ctypes.c_uint64),
        ("count", ctypes.c_uint64),
        ("plan_id", ctypes.c_uint64),
        ("epoch", ctypes.c_uint64),
        ("work", ctypes.c_uint64),
        ("chunks", ctypes.c_uint64),
        ("accepted", ctypes.c_uint64),
        ("digest", Digest),
        ("state", ctypes.c_uint32),
        ("crc", ctypes.c_uint32),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.PlanStatus.v1"


class FootForce(ctypes.Structure):
    LAYOUT = "99144cbb71bc90f4"
    _fields_ = [
        ("limb", ctypes.c_uint64),
        ("force", ctypes.c_double * 3),
        ("centre", ctypes.c_double * 3),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.FootForce.v1"


class State(ctypes.Structure):
    LAYOUT = "c49d4a627bae89cf"
    _fields_ = [
        ("schema", ctypes.c_uint64),
        ("instance", ctypes.c_uint64),
        ("plan_id", ctypes.c_uint64),
        ("epoch", ctypes.c_uint64),
        ("sequence", ctypes.c_uint64),
        ("tick", ctypes.c_uint64),
        ("mode", ctypes.c_uint32),
        ("feet_len", ctypes.c_uint32),
        ("waypoint", Waypoint),
        ("centre_of_mass", ctypes.c_double * 3),
        ("balance_margin", ctypes.c_double),
        ("friction_use", ctypes.c_double),
        ("torque_use", ctypes.c_double),
        ("feet", FootForce * CONTACTS_MAX),
        ("torques", ctypes.c_double * JOINTS_MAX),
    ]

    @staticmethod
    def type_name() -> str:
        return "surefoot.State.v1"


if __name__ == "__main__":
    for message in [Waypoint, Contact, PlanChunk, Margins, Standing, Correction, Feedback, StancePoseData, PlanRequest, PlanStatus, FootForce, State]:
        print(message.__name__, ctypes.sizeof(message))
        for field in message._fields_:
            place = getattr(message, field[0])
            print(field[0], place.offset, place.size)
