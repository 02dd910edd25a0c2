/* What the record says about its own worth: notes, and a verdict. */
#ifndef SHAKEDOWN_ANALYZER_JUDGEMENT_H
#define SHAKEDOWN_ANALYZER_JUDGEMENT_H

#include <stdbool.h>
#include <stddef.h>

#include "analyzer/run_file.h"
#include "common/status.h"

enum worth { WORTH_SOUND, WORTH_DOUBTFUL, WORTH_FAILED };

enum { JUDGEMENT_NOTES_MAX = 96 };

struct judgement_note {
    char stage[128];     /* "" : of the run */
    enum worth severity; /* WORTH_SOUND: a note only */
    char text[384];
};

struct judgement {
    enum worth verdict; /* the worst of the notes */
    enum status status; /* STATUS_OK if sound, STATUS_DOUBTFUL, or why it failed */
    bool ended;         /* the stage that is evaluated came to its end */
    double done;        /* part of the time of all stages, 0 ... 1 */
    char headline[256]; /* "complete", "INTERRUPTED at 7 %", "FAILED at 63 %: ..." */
    size_t n;
    struct judgement_note note[JUDGEMENT_NOTES_MAX];
};

/* Bounds. A residual of the ledger over the work of its stage, and overlaps over the smaller radius. */
extern const double judgement_residual_doubtful, judgement_overlap_note, judgement_overlap_failed;
extern const double judgement_inertial_note, judgement_rest_note, judgement_stress_note;

/* Judges a run whose stage number `stage` is evaluated: whether it came to its end; the notes that the simulator wrote
 * itself; and for each stage the residual of the ledger, the largest overlap, rest at the start, the inertial number
 * and the stress against its target. Where the simulator's notes on a stage are as severe as what is found here, they
 * stand alone. */
void judgement_make(struct judgement *judgement, const struct run *run, int stage);

/* "sound", "doubtful", "failed"; a note is "note" as a severity. */
const char *judgement_worth_name(enum worth worth);
const char *judgement_severity_name(enum worth worth);

/* Mean and largest |stress - target| over the target's size for samples [begin, end) of a stage, over the axes that
 * hold or follow a stress; NaN if there is none. */
void judgement_stress_error(const struct run *run, int stage, size_t begin, size_t end, double *mean, double *largest);

/* |residual of the ledger at the end| over the work of the samples [begin, end): the net work, or the sum of its
 * absolute changes where the net is below a tenth of that (*net false). NaN without work. */
double judgement_residual(const struct run *run, enum observable residual, size_t begin, size_t end, bool *net);

#endif
