/* A study: a series of runs of one scene, what is varied, what is evaluated and what it is compared with, read from a
 * libconfig file (docs/studies.md). */
#ifndef SHAKEDOWN_STUDIES_STUDY_H
#define SHAKEDOWN_STUDIES_STUDY_H

#include <stdbool.h>
#include <stdint.h>

#include "common/config_table.h"
#include "common/status.h"

enum { STUDY_PATH_MAX = 1024, STUDY_FACTORS_MAX = 4 };

/* Strings that own their memory. */
struct text_list {
    char **text; /* [n] */
    int n;
};

/* One setting of a factor. */
struct study_level {
    char name[CONFIG_STRING_MAX]; /* how it is called; of numbers: as %g prints them */
    double value;                 /* abscissa in figures; its place in the list where the file gives none */
    struct text_list set;         /* assignments "key=value" for the scene */
};

/* What is varied: a run is made for each combination of levels. */
struct study_factor {
    char name[CONFIG_STRING_MAX];
    char label[CONFIG_STRING_MAX]; /* in tables and figures; default: the name */
    char unit[CONFIG_STRING_MAX];
    double scale;              /* of values, before they go into the keys */
    bool numeric;              /* levels are numbers */
    struct study_level *level; /* [n_levels] */
    int n_levels;
};

/* A grid over factors, for each seed. */
struct study_series {
    char name[CONFIG_STRING_MAX];
    char scene[CONFIG_STRING_MAX];   /* path, relative to the study file */
    char prepare[CONFIG_STRING_MAX]; /* name of the last stage that runs share; "": none */
    struct text_list set;
    struct study_factor factor[STUDY_FACTORS_MAX];
    int n_factors;
    int64_t *seed; /* [n_seeds] */
    int n_seeds;
};

/* A condition on factors: "name" is at the level called "level". */
struct study_where {
    int n;
    char factor[STUDY_FACTORS_MAX][CONFIG_STRING_MAX];
    char level[STUDY_FACTORS_MAX][CONFIG_STRING_MAX];
};

/* A published number. */
struct study_paper {
    char quantity[CONFIG_STRING_MAX];
    char series[CONFIG_STRING_MAX]; /* "": any */
    struct study_where where;
    double value;
    double error;     /* as published; 0: none given */
    double tolerance; /* what counts as agreement, for scores; 0: a tenth of the value */
    char source[CONFIG_STRING_MAX];
};

enum study_evaluation_kind {
    EVALUATION_DECAY,   /* time in which the swings of a column die away, of one run */
    EVALUATION_SLOPE,   /* straight line through a part of a curve, of one run */
    EVALUATION_TANGENT, /* common tangent of Mohr circles, over the levels of a factor */
};

/* A number made from the runs beyond what the analyzer gives. */
struct study_evaluation {
    int kind; /* enum study_evaluation_kind */
    char name[CONFIG_STRING_MAX];
    char series[CONFIG_STRING_MAX];
    char column[CONFIG_STRING_MAX]; /* decay, slope: of curves.csv */
    double target;                  /* decay: what it comes to rest at; NaN: its last value */
    double from_s, to_s;            /* decay: window in the time of the stage; to_s 0: to its end */
    char x[CONFIG_STRING_MAX];      /* slope: the other column of curves.csv */
    double from, to;                /* slope: window in x; to 0: to its end */
    char along[CONFIG_STRING_MAX];  /* tangent: factor whose levels are the confining stresses */
    char major[CONFIG_STRING_MAX];  /* tangent: quantity that is the major stress */
};

enum study_figure_kind { FIGURE_CURVES, FIGURE_POINTS, FIGURE_MOHR };
enum { FIGURE_WIDTH_DEFAULT = 720 };

struct study_figure {
    int kind; /* enum study_figure_kind */
    char name[CONFIG_STRING_MAX];
    char title[CONFIG_STRING_MAX]; /* what is to be seen; also the text alternative */
    char series[CONFIG_STRING_MAX];
    char table[CONFIG_STRING_MAX]; /* curves: curves.csv or cycles.csv */
    char x[CONFIG_STRING_MAX];     /* curves: column; points: factor */
    char y[CONFIG_STRING_MAX];     /* curves: column; points: quantity */
    char x_label[CONFIG_STRING_MAX], y_label[CONFIG_STRING_MAX];
    double x_scale, y_scale;
    double x_min, x_max; /* both 0: all */
    bool x_log, y_log;
    bool mean;                          /* curves: mean and spread over seeds; else the first seed as it is */
    char evaluation[CONFIG_STRING_MAX]; /* mohr: name of a tangent */
    struct study_where where;
};

struct study {
    char path[STUDY_PATH_MAX];   /* of the file */
    char folder[STUDY_PATH_MAX]; /* the file's, that paths in it are relative to */
    char name[CONFIG_STRING_MAX];
    char title[CONFIG_STRING_MAX];
    char score[CONFIG_STRING_MAX]; /* factor whose levels are ranked by their distance from the paper; "": none */
    struct text_list method;       /* paragraphs of the report */
    struct text_list quantities;   /* keys of analysis.json */
    struct study_series *series;   /* [n_series] */
    struct study_paper *paper;     /* [n_paper] */
    struct study_evaluation *evaluation;
    struct study_figure *figure;
    int n_series, n_paper, n_evaluations, n_figures;
    char *text; /* the file as read */
};

/* Reads a study file and applies `n_set` assignments "key=value" to it: those that begin with "study." to the study
 * itself ("study.seeds=3"), all others to the scene of every run, after what the file sets.
 * STATUS_IO, STATUS_NO_MEMORY, STATUS_CONFIG with file, line, key and what is allowed. On success release it with
 * study_free. */
enum status study_load(struct study *study, const char *path, const char *const *set, int n_set) MUST_USE;

void study_free(struct study *study);

/* A copy of `text` goes to the end. STATUS_NO_MEMORY. */
enum status text_list_add(struct text_list *list, const char *text) MUST_USE;
void text_list_free(struct text_list *list);

/* The factor of a series by its name; -1 if it has none of it. */
int study_factor_find(const struct study_series *series, const char *name);

/* Prints every key that a study file may have, in Markdown. */
void study_print_reference(FILE *out);

#endif
