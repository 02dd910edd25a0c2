/* Puts chunked messages together: a chunk is taken only if it is the next one of its set or frame and fits the run. */
#ifndef SHAKEDOWN_RECORDER_CHUNK_ASSEMBLY_H
#define SHAKEDOWN_RECORDER_CHUNK_ASSEMBLY_H

#include <stdbool.h>

#include "common/history_kind.h"
#include "common/message.h"

/* A field of the contacts' history, as RUN_INFO says. */
struct contact_field {
    char name[HISTORY_NAME_MAX], unit[HISTORY_UNIT_MAX];
    enum history_kind kind;
};

/* What RUN_INFO fixes for all other records. */
struct run_facts {
    int dimension;   /* 2 or 3 */
    int n_particles; /* N */
    int n_walls;     /* 2 dimension */
    bool frictional;
    int n_history;
    struct contact_field history[HISTORY_FIELDS_MAX];
};

/* Components of a field of the history in run.h5: 1 or 3. */
int history_width(const struct contact_field *column);

struct run_facts run_facts_of(const shakedown_run_info_t *info);

/* Radii and masses of all particles. */
struct particle_set {
    int n_chunks, next_chunk; /* complete when equal and not 0 */
    int filled;               /* particles so far */
    double *radius_m;         /* [N] */
    double *mass_kg;          /* [N] */
    double radius_max_m;
};

/* What the chunks of one frame share. */
struct frame_place {
    int frame; /* the one being put together */
    int next_chunk, n_chunks;
    int64_t step;
    double time_s;
};

/* One frame of particles, always with three components (2D: y = 0). */
struct particle_frame {
    struct frame_place place;
    int stage;
    double box_lo_m[3], box_hi_m[3]; /* 2D: y is 0 */
    int filled;
    double *position_m;                 /* [N][3] */
    double *velocity_m_per_s;           /* [N][3] */
    double *angular_velocity_rad_per_s; /* [N][3] with friction, else NULL */
};

/* One frame of contacts; arrays grow with the largest frame. */
struct contact_frame {
    struct frame_place place;
    int64_t count, capacity;
    int32_t *pair;                       /* [count][2] */
    double *overlap_m;                   /* [count] */
    double *normal_force_n;              /* [count] */
    double *normal;                      /* [count][3] */
    double *tangential_force_n;          /* [count][3], zero without friction */
    int8_t *sliding;                     /* [count], zero without friction */
    double *history[HISTORY_FIELDS_MAX]; /* of each field of the run [count][history_width] */
};

enum status particle_set_init(struct particle_set *set, const struct run_facts *facts) MUST_USE;
void particle_set_free(struct particle_set *set);
void particle_set_restart(struct particle_set *set); /* a run that goes on sends it again */
bool particle_set_is_complete(const struct particle_set *set);

/* Takes a chunk, or says STATUS_FORMAT and changes nothing. */
enum status particle_set_add(struct particle_set *set, const struct run_facts *facts,
                             const shakedown_particles_t *chunk) MUST_USE;

enum status particle_frame_init(struct particle_frame *frame, const struct run_facts *facts) MUST_USE;
void particle_frame_free(struct particle_frame *frame);

/* Takes a chunk, or says STATUS_FORMAT and changes nothing. *full: the frame is complete; after having used it, the
 * caller goes on with frame_place_next. */
enum status particle_frame_add(struct particle_frame *frame, const struct run_facts *facts,
                               const shakedown_frame_particles_t *chunk, bool *full) MUST_USE;

void contact_frame_free(struct contact_frame *frame);

/* The same for contacts. `frame` starts as zero. Also STATUS_NO_MEMORY. */
enum status contact_frame_add(struct contact_frame *frame, const struct run_facts *facts,
                              const shakedown_frame_contacts_t *chunk, bool *full) MUST_USE;

/* Makes ready for the next frame. */
void frame_place_next(struct frame_place *place);

#endif
