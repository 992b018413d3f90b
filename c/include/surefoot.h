/* Reads the messages of a running walk from C11 and C++11. Link with -lsurefoot_c
   (cargo build --release -p surefoot-c).

   A reader only subscribes: it changes nothing, and no process waits for it. Read often: of the
   chunks eight wait for a reader, of the states and set-points 256, of the others the latest. A
   reader is used by one thread at a time. */
#ifndef SUREFOOT_H
#define SUREFOOT_H

#include <stddef.h>
#include <stdint.h>

#include "surefoot_messages.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct surefoot_Reader surefoot_Reader;

/* Attaches to the instance `name` and waits up to `wait_seconds` for it to appear. NULL on an error,
   whose text is written to the `error_size` bytes at `error`. */
surefoot_Reader *surefoot_reader_open(const char *name, double wait_seconds, char *error,
                                      size_t error_size);

/* Lets go of the instance. NULL is allowed. */
void surefoot_reader_close(surefoot_Reader *reader);

/* Each writes the next message to `out`: 1 if one has come, 0 if none has, -1 on an error. Damaged
   messages are skipped. */
int surefoot_reader_next_chunk(surefoot_Reader *reader, surefoot_PlanChunk *out);
int surefoot_reader_next_feedback(surefoot_Reader *reader, surefoot_Feedback *out);
int surefoot_reader_next_state(surefoot_Reader *reader, surefoot_SimulationState *out);
int surefoot_reader_next_set_point(surefoot_Reader *reader, surefoot_SetPoint *out);
int surefoot_reader_next_description(surefoot_Reader *reader, surefoot_Description *out);

/* The number of chunks that were sent and not received. Read feedback, then chunks until none is
   left, so that the last ones count. */
uint64_t surefoot_reader_missed_chunks(const surefoot_Reader *reader);

/* 1 while a planner or a controller is attached, else 0. */
int surefoot_reader_is_attended(const surefoot_Reader *reader);

/* The text of the last error, valid until the next call. */
const char *surefoot_reader_error(const surefoot_Reader *reader);

#ifdef __cplusplus
}
#endif

#endif
