/* How many of the threads that there are shorten a step, found out while running: other programs take cores away, and
 * small samples do not feed many. Counts threads and seconds alone; results do not depend on it. */
#ifndef SHAKEDOWN_SIM_SAMPLE_THREAD_CHOICE_H
#define SHAKEDOWN_SIM_SAMPLE_THREAD_CHOICE_H

#include <stdbool.h>

struct thread_choice {
    int most;       /* threads that there are */
    int best;       /* what has been found best so far */
    int use;        /* what the next step is to take: best, or another number that is tried */
    bool upwards;   /* the next trial is of more threads */
    double usual_s; /* a step with `best`, of late; 0: not known yet */
    double spent_s; /* of the steps that are being looked at */
    int steps;      /* and how many they are */
    double since_s; /* time since the last trial, */
    double pause_s; /* and how long to wait for the next one */
};

/* Begins with all of them. */
struct thread_choice thread_choice_of(int most);

/* A step with choice->use threads has taken step_s seconds. */
void thread_choice_step(struct thread_choice *choice, double step_s);

#endif
