/* The messages of Surefoot in C11. Generated from shared-types/src/message; see shared-types/tests/mirrors.rs. */
#ifndef SUREFOOT_MESSAGES_H
#define SUREFOOT_MESSAGES_H

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

#define SUREFOOT_JOINTS_MAX 48
#define SUREFOOT_CHUNK_WAYPOINTS_MAX 32
#define SUREFOOT_CONTACTS_MAX 4
#define SUREFOOT_POLYGON_VERTICES_MAX 16
#define SUREFOOT_CORRECTIONS_MAX 32

typedef struct { uint8_t bytes[32]; } surefoot_Digest;

#define SUREFOOT_WAYPOINT_TYPE_NAME "surefoot.Waypoint.v1"
#define SUREFOOT_WAYPOINT_LAYOUT "692f60eacc1a6302"
typedef struct {
    double time;
    double root_position[3];
    double root_rotation[4];
    double q[SUREFOOT_JOINTS_MAX];
} surefoot_Waypoint;
static_assert(sizeof(surefoot_Waypoint) == 448, "size");
static_assert(offsetof(surefoot_Waypoint, time) == 0, "offset");
static_assert(offsetof(surefoot_Waypoint, root_position) == 8, "offset");
static_assert(offsetof(surefoot_Waypoint, root_rotation) == 32, "offset");
static_assert(offsetof(surefoot_Waypoint, q) == 64, "offset");

#define SUREFOOT_CONTACT_TYPE_NAME "surefoot.Contact.v1"
#define SUREFOOT_CONTACT_LAYOUT "93de07947c76db00"
typedef struct {
    uint32_t limb;
    uint32_t polygon_len;
    double position[3];
    double rotation[4];
    double polygon[SUREFOOT_POLYGON_VERTICES_MAX][2];
} surefoot_Contact;
static_assert(sizeof(surefoot_Contact) == 320, "size");
static_assert(offsetof(surefoot_Contact, limb) == 0, "offset");
static_assert(offsetof(surefoot_Contact, polygon_len) == 4, "offset");
static_assert(offsetof(surefoot_Contact, position) == 8, "offset");
static_assert(offsetof(surefoot_Contact, rotation) == 32, "offset");
static_assert(offsetof(surefoot_Contact, polygon) == 64, "offset");

#define SUREFOOT_PLAN_CHUNK_TYPE_NAME "surefoot.PlanChunk.v1"
#define SUREFOOT_PLAN_CHUNK_LAYOUT "090b3ef386060954"
typedef struct {
    uint64_t schema;
    uint64_t session;
    uint64_t target_instance;
    uint64_t plan_id;
    uint64_t epoch;
    uint64_t sequence;
    uint32_t flags;
    uint32_t mode;
    uint32_t contacts_len;
    uint32_t waypoints_len;
    uint32_t joints_len;
    uint32_t crc;
    surefoot_Digest robot;
    surefoot_Digest world;
    surefoot_Digest config;
    surefoot_Digest stream;
    surefoot_Contact contacts[SUREFOOT_CONTACTS_MAX];
    surefoot_Waypoint waypoints[SUREFOOT_CHUNK_WAYPOINTS_MAX];
} surefoot_PlanChunk;
static_assert(sizeof(surefoot_PlanChunk) == 15816, "size");
static_assert(offsetof(surefoot_PlanChunk, schema) == 0, "offset");
static_assert(offsetof(surefoot_PlanChunk, session) == 8, "offset");
static_assert(offsetof(surefoot_PlanChunk, target_instance) == 16, "offset");
static_assert(offsetof(surefoot_PlanChunk, plan_id) == 24, "offset");
static_assert(offsetof(surefoot_PlanChunk, epoch) == 32, "offset");
static_assert(offsetof(surefoot_PlanChunk, sequence) == 40, "offset");
static_assert(offsetof(surefoot_PlanChunk, flags) == 48, "offset");
static_assert(offsetof(surefoot_PlanChunk, mode) == 52, "offset");
static_assert(offsetof(surefoot_PlanChunk, contacts_len) == 56, "offset");
static_assert(offsetof(surefoot_PlanChunk, waypoints_len) == 60, "offset");
static_assert(offsetof(surefoot_PlanChunk, joints_len) == 64, "offset");
static_assert(offsetof(surefoot_PlanChunk, crc) == 68, "offset");
static_assert(offsetof(surefoot_PlanChunk, robot) == 72, "offset");
static_assert(offsetof(surefoot_PlanChunk, world) == 104, "offset");
static_assert(offsetof(surefoot_PlanChunk, config) == 136, "offset");
static_assert(offsetof(surefoot_PlanChunk, stream) == 168, "offset");
static_assert(offsetof(surefoot_PlanChunk, contacts) == 200, "offset");
static_assert(offsetof(surefoot_PlanChunk, waypoints) == 1480, "offset");

#define SUREFOOT_MARGINS_TYPE_NAME "surefoot.Margins.v1"
#define SUREFOOT_MARGINS_LAYOUT "babb94a9813dc304"
typedef struct {
    double limits;
    double contact;
    double balance;
    double collision;
    double self_collision;
    double torque;
} surefoot_Margins;
static_assert(sizeof(surefoot_Margins) == 48, "size");
static_assert(offsetof(surefoot_Margins, limits) == 0, "offset");
static_assert(offsetof(surefoot_Margins, contact) == 8, "offset");
static_assert(offsetof(surefoot_Margins, balance) == 16, "offset");
static_assert(offsetof(surefoot_Margins, collision) == 24, "offset");
static_assert(offsetof(surefoot_Margins, self_collision) == 32, "offset");
static_assert(offsetof(surefoot_Margins, torque) == 40, "offset");

#define SUREFOOT_STANDING_TYPE_NAME "surefoot.Standing.v1"
#define SUREFOOT_STANDING_LAYOUT "7bcc833a9657f302"
typedef struct {
    uint32_t mode;
    uint32_t contacts_len;
    surefoot_Waypoint waypoint;
    surefoot_Contact contacts[SUREFOOT_CONTACTS_MAX];
} surefoot_Standing;
static_assert(sizeof(surefoot_Standing) == 1736, "size");
static_assert(offsetof(surefoot_Standing, mode) == 0, "offset");
static_assert(offsetof(surefoot_Standing, contacts_len) == 4, "offset");
static_assert(offsetof(surefoot_Standing, waypoint) == 8, "offset");
static_assert(offsetof(surefoot_Standing, contacts) == 456, "offset");

#define SUREFOOT_CORRECTION_TYPE_NAME "surefoot.Correction.v1"
#define SUREFOOT_CORRECTION_LAYOUT "a26bc66974604ab1"
typedef struct {
    uint32_t kind;
    uint32_t shape;
    double position[3];
    double rotation[4];
    double half_extents[3];
} surefoot_Correction;
static_assert(sizeof(surefoot_Correction) == 88, "size");
static_assert(offsetof(surefoot_Correction, kind) == 0, "offset");
static_assert(offsetof(surefoot_Correction, shape) == 4, "offset");
static_assert(offsetof(surefoot_Correction, position) == 8, "offset");
static_assert(offsetof(surefoot_Correction, rotation) == 32, "offset");
static_assert(offsetof(surefoot_Correction, half_extents) == 64, "offset");

#define SUREFOOT_FEEDBACK_TYPE_NAME "surefoot.Feedback.v1"
#define SUREFOOT_FEEDBACK_LAYOUT "220534f1332201cb"
typedef struct {
    uint64_t schema;
    uint64_t instance;
    uint64_t session;
    uint64_t plan_id;
    uint64_t epoch;
    uint64_t next_sequence;
    uint64_t count;
    uint32_t verdict;
    uint32_t check;
    uint64_t refused_sequence;
    uint32_t refused_waypoint;
    uint32_t finished;
    uint64_t duplicated;
    uint64_t gaps;
    uint64_t walked;
    uint32_t busy;
    uint32_t corrections_len;
    uint32_t reserved;
    uint32_t crc;
    surefoot_Digest stream;
    surefoot_Margins margins;
    surefoot_Standing standing;
    surefoot_Correction corrections[SUREFOOT_CORRECTIONS_MAX];
} surefoot_Feedback;
static_assert(sizeof(surefoot_Feedback) == 4752, "size");
static_assert(offsetof(surefoot_Feedback, schema) == 0, "offset");
static_assert(offsetof(surefoot_Feedback, instance) == 8, "offset");
static_assert(offsetof(surefoot_Feedback, session) == 16, "offset");
static_assert(offsetof(surefoot_Feedback, plan_id) == 24, "offset");
static_assert(offsetof(surefoot_Feedback, epoch) == 32, "offset");
static_assert(offsetof(surefoot_Feedback, next_sequence) == 40, "offset");
static_assert(offsetof(surefoot_Feedback, count) == 48, "offset");
static_assert(offsetof(surefoot_Feedback, verdict) == 56, "offset");
static_assert(offsetof(surefoot_Feedback, check) == 60, "offset");
static_assert(offsetof(surefoot_Feedback, refused_sequence) == 64, "offset");
static_assert(offsetof(surefoot_Feedback, refused_waypoint) == 72, "offset");
static_assert(offsetof(surefoot_Feedback, finished) == 76, "offset");
static_assert(offsetof(surefoot_Feedback, duplicated) == 80, "offset");
static_assert(offsetof(surefoot_Feedback, gaps) == 88, "offset");
static_assert(offsetof(surefoot_Feedback, walked) == 96, "offset");
static_assert(offsetof(surefoot_Feedback, busy) == 104, "offset");
static_assert(offsetof(surefoot_Feedback, corrections_len) == 108, "offset");
static_assert(offsetof(surefoot_Feedback, reserved) == 112, "offset");
static_assert(offsetof(surefoot_Feedback, crc) == 116, "offset");
static_assert(offsetof(surefoot_Feedback, stream) == 120, "offset");
static_assert(offsetof(surefoot_Feedback, margins) == 152, "offset");
static_assert(offsetof(surefoot_Feedback, standing) == 200, "offset");
static_assert(offsetof(surefoot_Feedback, corrections) == 1936, "offset");

#define SUREFOOT_MARK_DATA_TYPE_NAME "surefoot.MarkData.v1"
#define SUREFOOT_MARK_DATA_LAYOUT "4a02cea3b49035ee"
typedef struct {
    double position[3];
    double yaw;
    double feet_apart;
} surefoot_MarkData;
static_assert(sizeof(surefoot_MarkData) == 40, "size");
static_assert(offsetof(surefoot_MarkData, position) == 0, "offset");
static_assert(offsetof(surefoot_MarkData, yaw) == 24, "offset");
static_assert(offsetof(surefoot_MarkData, feet_apart) == 32, "offset");

#define SUREFOOT_PLAN_REQUEST_TYPE_NAME "surefoot.PlanRequest.v1"
#define SUREFOOT_PLAN_REQUEST_LAYOUT "04a8430304f257d9"
typedef struct {
    uint64_t schema;
    uint64_t client;
    uint64_t number;
    uint64_t seed;
    uint64_t work_max;
    uint32_t kind;
    uint32_t crc;
    surefoot_MarkData start;
    surefoot_MarkData goal;
} surefoot_PlanRequest;
static_assert(sizeof(surefoot_PlanRequest) == 128, "size");
static_assert(offsetof(surefoot_PlanRequest, schema) == 0, "offset");
static_assert(offsetof(surefoot_PlanRequest, client) == 8, "offset");
static_assert(offsetof(surefoot_PlanRequest, number) == 16, "offset");
static_assert(offsetof(surefoot_PlanRequest, seed) == 24, "offset");
static_assert(offsetof(surefoot_PlanRequest, work_max) == 32, "offset");
static_assert(offsetof(surefoot_PlanRequest, kind) == 40, "offset");
static_assert(offsetof(surefoot_PlanRequest, crc) == 44, "offset");
static_assert(offsetof(surefoot_PlanRequest, start) == 48, "offset");
static_assert(offsetof(surefoot_PlanRequest, goal) == 88, "offset");

#define SUREFOOT_PLAN_STATUS_TYPE_NAME "surefoot.PlanStatus.v1"
#define SUREFOOT_PLAN_STATUS_LAYOUT "9c54fee5c01ea6ee"
typedef struct {
    uint64_t schema;
    uint64_t session;
    uint64_t client;
    uint64_t number;
    uint64_t count;
    uint64_t plan_id;
    uint64_t epoch;
    uint64_t work;
    uint64_t chunks;
    uint64_t accepted;
    surefoot_Digest digest;
    uint32_t state;
    uint32_t crc;
} surefoot_PlanStatus;
static_assert(sizeof(surefoot_PlanStatus) == 120, "size");
static_assert(offsetof(surefoot_PlanStatus, schema) == 0, "offset");
static_assert(offsetof(surefoot_PlanStatus, session) == 8, "offset");
static_assert(offsetof(surefoot_PlanStatus, client) == 16, "offset");
static_assert(offsetof(surefoot_PlanStatus, number) == 24, "offset");
static_assert(offsetof(surefoot_PlanStatus, count) == 32, "offset");
static_assert(offsetof(surefoot_PlanStatus, plan_id) == 40, "offset");
static_assert(offsetof(surefoot_PlanStatus, epoch) == 48, "offset");
static_assert(offsetof(surefoot_PlanStatus, work) == 56, "offset");
static_assert(offsetof(surefoot_PlanStatus, chunks) == 64, "offset");
static_assert(offsetof(surefoot_PlanStatus, accepted) == 72, "offset");
static_assert(offsetof(surefoot_PlanStatus, digest) == 80, "offset");
static_assert(offsetof(surefoot_PlanStatus, state) == 112, "offset");
static_assert(offsetof(surefoot_PlanStatus, crc) == 116, "offset");

#define SUREFOOT_FOOT_FORCE_TYPE_NAME "surefoot.FootForce.v1"
#define SUREFOOT_FOOT_FORCE_LAYOUT "99144cbb71bc90f4"
typedef struct {
    uint64_t limb;
    double force[3];
    double centre[3];
} surefoot_FootForce;
static_assert(sizeof(surefoot_FootForce) == 56, "size");
static_assert(offsetof(surefoot_FootForce, limb) == 0, "offset");
static_assert(offsetof(surefoot_FootForce, force) == 8, "offset");
static_assert(offsetof(surefoot_FootForce, centre) == 32, "offset");

#define SUREFOOT_STATE_TYPE_NAME "surefoot.State.v1"
#define SUREFOOT_STATE_LAYOUT "c49d4a627bae89cf"
typedef struct {
    uint64_t schema;
    uint64_t instance;
    uint64_t plan_id;
    uint64_t epoch;
    uint64_t sequence;
    uint64_t tick;
    uint32_t mode;
    uint32_t feet_len;
    surefoot_Waypoint waypoint;
    double centre_of_mass[3];
    double balance_margin;
    double friction_use;
    double torque_use;
    surefoot_FootForce feet[SUREFOOT_CONTACTS_MAX];
    double torques[SUREFOOT_JOINTS_MAX];
} surefoot_State;
static_assert(sizeof(surefoot_State) == 1160, "size");
static_assert(offsetof(surefoot_State, schema) == 0, "offset");
static_assert(offsetof(surefoot_State, instance) == 8, "offset");
static_assert(offsetof(surefoot_State, plan_id) == 16, "offset");
static_assert(offsetof(surefoot_State, epoch) == 24, "offset");
static_assert(offsetof(surefoot_State, sequence) == 32, "offset");
static_assert(offsetof(surefoot_State, tick) == 40, "offset");
static_assert(offsetof(surefoot_State, mode) == 48, "offset");
static_assert(offsetof(surefoot_State, feet_len) == 52, "offset");
static_assert(offsetof(surefoot_State, waypoint) == 56, "offset");
static_assert(offsetof(surefoot_State, centre_of_mass) == 504, "offset");
static_assert(offsetof(surefoot_State, balance_margin) == 528, "offset");
static_assert(offsetof(surefoot_State, friction_use) == 536, "offset");
static_assert(offsetof(surefoot_State, torque_use) == 544, "offset");
static_assert(offsetof(surefoot_State, feet) == 552, "offset");
static_assert(offsetof(surefoot_State, torques) == 776, "offset");

#endif
