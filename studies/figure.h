/* Figures of a study: lines of numbers first, then files. */
#ifndef SHAKEDOWN_STUDIES_FIGURE_H
#define SHAKEDOWN_STUDIES_FIGURE_H

#include "common/status.h"
#include "studies/results.h"

enum line_style {
    LINE_PLAIN,  /* x, y in order */
    LINE_BAND,   /* mean and standard deviation as a band */
    LINE_POINTS, /* points with error bars, joined */
    LINE_PAPER,  /* the published points */
};

struct figure_line {
    char label[512]; /* "": not in the key */
    int style;       /* enum line_style */
    int colour;      /* lines of one colour belong together */
    int n;
    double *x, *y, *error; /* [n]; error NaN: none */
};

struct figure_lines {
    struct figure_line *line;
    int n;
};

/* The lines of a figure from the runs below `out`. STATUS_FORMAT (no such column), STATUS_CONFIG (no such quantity),
 * STATUS_IO, STATUS_NO_MEMORY. On success release them with figure_lines_free. */
enum status figure_lines_make(struct figure_lines *lines, const struct results *results,
                              const struct study_figure *figure, const char *out) MUST_USE;

void figure_lines_free(struct figure_lines *lines);

/* Writes FOLDER/NAME.gp, .csv (the numbers drawn), and by gnuplot .svg, .pdf and .png. STATUS_IO. */
enum status figure_draw(const struct figure_lines *lines, const struct study_figure *figure,
                        const char *folder) MUST_USE;

#endif
