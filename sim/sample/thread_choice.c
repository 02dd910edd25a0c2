#include "sim/sample/thread_choice.h"

/* What is looked at together: long enough to hold a few of the slices of time that an operating system deals out. */
static const double WINDOW_S = 0.02;
enum { WINDOW_STEPS = 4 };

/* Trials: the first ones soon; then ever more seldom, as they cost up to a window each. */
static const double FIRST_PAUSE_S = 0.1, LAST_PAUSE_S = 6.4;

/* What a step with more threads, or with fewer, may take at most of the usual time to be better. A step that takes so
 * much longer than usual asks for a trial at once, and a trial that takes so much longer is over. */
static const double MORE = 0.95, FEWER = 1.01, SLOW = 1.15, HOPELESS = 1.5;

struct thread_choice thread_choice_of(int most)
{
    return (struct thread_choice){.most = most, .best = most, .use = most, .pause_s = FIRST_PAUSE_S};
}

/* Half as many, or twice as many, by turns. */
static void begin_trial(struct thread_choice *choice)
{
    const int half = (choice->best + 1) / 2, twice = 2 * choice->best < choice->most ? 2 * choice->best : choice->most;
    const bool up = choice->best == 1 || (choice->upwards && choice->best < choice->most);
    choice->use = up ? twice : half;
    choice->upwards = !up;
}

static void end_trial(struct thread_choice *choice, double mean_s)
{
    const bool better = mean_s < choice->usual_s * (choice->use > choice->best ? MORE : FEWER);
    if (better) {
        choice->upwards = choice->use > choice->best;
        choice->best = choice->use;
        choice->usual_s = mean_s;
    }
    choice->pause_s = better ? FIRST_PAUSE_S : 2 * choice->pause_s < LAST_PAUSE_S ? 2 * choice->pause_s : LAST_PAUSE_S;
    choice->use = choice->best;
    choice->since_s = 0;
}

static void end_window(struct thread_choice *choice, double mean_s)
{
    const double before = choice->usual_s, of_new = 0.25;
    const bool slow = before > 0 && mean_s > SLOW * before && choice->since_s > FIRST_PAUSE_S;
    choice->usual_s = before > 0 ? (1 - of_new) * before + of_new * mean_s : mean_s;
    if (slow || choice->since_s > choice->pause_s)
        begin_trial(choice);
}

void thread_choice_step(struct thread_choice *choice, double step_s)
{
    const bool trial = choice->use != choice->best;
    if (choice->most == 1)
        return;
    choice->spent_s += step_s;
    choice->since_s += step_s;
    choice->steps++;
    const double mean_s = choice->spent_s / choice->steps;
    const bool hopeless = trial && choice->spent_s > HOPELESS * WINDOW_STEPS * choice->usual_s;
    if (!hopeless && (choice->steps < WINDOW_STEPS || choice->spent_s < WINDOW_S))
        return;
    if (trial)
        end_trial(choice, mean_s);
    else
        end_window(choice, mean_s);
    choice->spent_s = 0;
    choice->steps = 0;
}
