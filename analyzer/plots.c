#include "analyzer/plots.h"

#include <errno.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

/* Colours that stay apart for colour-blind readers (Okabe & Ito 2008). */
#define BLUE   "#0072B2"
#define ORANGE "#D55E00"
#define GREEN  "#009E73"
#define GREY   "#999999"

static const char preamble[] =
    "# Made by analyzer; run `gnuplot %s.gp` here to make the plot again.\n"
    "set encoding utf8\n"
    "set datafile separator ','\n"
    "set datafile columnheaders\n"
    "set terminal svg size 720,500 enhanced font 'DejaVu Sans,15' background 'white'\n"
    "set output '%s.svg'\n"
    "set border 31 linewidth 1.2\n"
    "set tics nomirror in scale 0.8\n"
    "set mxtics 2\nset mytics 2\nset format '%%.4g'\nset xtics font ',13'\nset ytics font ',13'\n"
    "set grid linewidth 0.6 linecolor '#cccccc'\n"
    "set autoscale xfix\nset offsets 0, graph 0.02, graph 0.05, graph 0.05\n"
    "set key outside above horizontal Left reverse samplen 2 spacing 1.15 width 1 font ',12'\n";

static const char epilogue[] =
    "set terminal pngcairo size 1440,1000 enhanced font 'DejaVu Sans,15' fontscale 2 linewidth 2 "
    "pointscale 2 background 'white'\n"
    "set output '%s.png'\n"
    "replot\n"
    "unset output\n";

void plots_quoted(FILE *out, const char *text, char mark)
{
    fputc(mark, out);
    for (; *text; text++) {
        if (*text == mark)
            fputc(mark, out);
        fputc((unsigned char)*text < ' ' ? ' ' : *text, out);
    }
    fputc(mark, out);
}

/* What a script body needs. Abscissa: axial strain in per cent for a strain-controlled stage, else time. */
struct plot {
    const struct analysis *analysis;
    FILE *out;
    const char *x; /* gnuplot expression */
};

/* Columns of axial and volumetric strain in the measure asked for. */
static enum curve plot_axial(const struct plot *plot)
{
    return curve_axial_strain(plot->analysis->run.scene->analysis.strain);
}

static enum curve plot_volumetric(const struct plot *plot)
{
    return curve_volumetric_strain(plot->analysis->run.scene->analysis.strain);
}

/* Unit in which stresses are read at a glance, chosen by the largest of the stage: factor from Pa, and name. */
struct stress_unit {
    double factor;
    const char *name;
};

static struct stress_unit stress_unit(const struct plot *plot)
{
    const struct curves *curves = &plot->analysis->curves;
    double largest = 0;
    for (size_t k = 0; k < curves->n; k++)
        largest = fmax(largest, fmax(fabs(curves->column[CURVE_SIGMA_ZZ][k]), fabs(curves->column[CURVE_SIGMA_XX][k])));
    if (largest >= 1e6)
        return (struct stress_unit){1e-6, "MPa"};
    return largest >= 1e4 ? (struct stress_unit){1e-3, "kPa"} : (struct stress_unit){1, "Pa"};
}

static bool defined(const struct plot *plot, enum quantity_id id)
{
    return isfinite(plot->analysis->quantity[id].value);
}

static void abscissa(const struct plot *plot)
{
    if (plot->analysis->curves.controls.kind == TEST_SHEAR)
        fprintf(plot->out, "set xlabel 'axial strain {/Symbol e}_{zz} [%%]'\n");
    else
        fprintf(plot->out, "set xlabel 'time in stage [s]'\n");
}

static void stress_strain(const struct plot *plot)
{
    const struct quantity *q = plot->analysis->quantity;
    bool corrected = isfinite(plot->analysis->curves.controls.lateral_pressure_pa);
    abscissa(plot);
    const struct stress_unit unit = stress_unit(plot);
    fprintf(plot->out, "s = %g\nset ylabel 'stress [%s]'\n", unit.factor, unit.name);
    bool peak = defined(plot, QUANTITY_PEAK_SIGMA_CORR);
    if (peak)
        fprintf(plot->out, "$peak << END\nx,y,u\n%.10g,%.10g,%.10g\nEND\n", 100 * q[QUANTITY_PEAK_EPS_ZZ].value,
                q[QUANTITY_PEAK_SIGMA_CORR].value, fmax(0, q[QUANTITY_PEAK_SIGMA_CORR].uncertainty));
    fprintf(plot->out,
            "plot 'curves.csv' using (%s):(s*column('sigma_zz_pa')) with lines linewidth 2 linecolor '" BLUE
            "' title '{/Symbol s}_{zz}', \\\n"
            "     '' using (%s):(s*column('sigma_xx_pa')) with lines linewidth 2 linecolor '" GREEN
            "' title '{/Symbol s}_{xx}'",
            plot->x, plot->x);
    if (corrected)
        fprintf(plot->out,
                ", \\\n     '' using (%s):(s*column('sigma_corr_pa')) with lines linewidth 1.5 dashtype (14,7) "
                "linecolor '" ORANGE "' title '{/Symbol s}_{corr} = p_x {/Symbol s}_{zz}/{/Symbol s}_{xx}'",
                plot->x);
    if (peak)
        fprintf(plot->out,
                ", \\\n     $peak using 1:(s*$2):(s*$3) with yerrorbars pointtype 7 pointsize 0.8 linewidth 1.5 "
                "linecolor 'black' "
                "title '%s'",
                q[QUANTITY_PEAK_SIGMA_CORR].text[0] ? "largest {/Symbol s}_{corr}" : "peak");
    fputc('\n', plot->out);
}

/* Mean point of eps_v over eps_zz in the window of a quantity: a fitted line passes through it. */
static void mean_point(const struct plot *plot, const struct quantity *quantity, double *x, double *y)
{
    const struct curves *curves = &plot->analysis->curves;
    const double *axial = curves->column[plot_axial(plot)], *volumetric = curves->column[plot_volumetric(plot)];
    double count = 0;
    *x = *y = 0;
    for (size_t k = 0; k < curves->n; k++) {
        double eps = axial[k];
        if (eps < quantity->window[0] - 1e-12 || eps > quantity->window[1] + 1e-12)
            continue;
        *x += eps;
        *y += volumetric[k];
        count++;
    }
    *x /= count;
    *y /= count;
}

/* A fitted slope times `sign`, drawn over its window stretched by `stretch` to the right. */
static void slope_line(const struct plot *plot, enum quantity_id id, double sign, double stretch, const char *title)
{
    const struct quantity *quantity = &plot->analysis->quantity[id];
    double x, y, a = quantity->window[0],
                 b = quantity->window[0] + stretch * (quantity->window[1] - quantity->window[0]);
    if (!defined(plot, id) || plot->analysis->curves.controls.extension)
        return;
    mean_point(plot, quantity, &x, &y);
    if (!isfinite(x)) /* no sample in the window */
        return;
    /* a slope of logarithmic strains, drawn over engineering ones */
    double slope = sign * quantity->value;
    if (plot_axial(plot) == CURVE_EPS_ZZ)
        slope *= (1 - y) / (1 - x);
    fprintf(
        plot->out,
        ", \\\n     [%.10g:%.10g] %.10g + (%.10g)*(x - %.10g) with lines linewidth 2 dashtype %s linecolor '%s' title "
        "'%s: slope %.3g'",
        100 * a, 100 * b, 100 * y, slope, 100 * x, stretch > 1 ? "(4,6)" : "(14,7)", stretch > 1 ? ORANGE : "black",
        title, sign * quantity->value);
}

static void volumetric_strain(const struct plot *plot)
{
    abscissa(plot);
    fprintf(plot->out,
            "set ylabel 'volumetric strain {/Symbol e}_V [%%]'\n"
            "plot 'curves.csv' using (%s):(100*column('%s')) with lines linewidth 2 linecolor '" BLUE
            "' title '{/Symbol e}_V (compression positive)'",
            plot->x, curve_name(plot_volumetric(plot)));
    if (plot->analysis->curves.controls.kind == TEST_SHEAR) {
        slope_line(plot, QUANTITY_EPS_V_SLOPE_INITIAL, 1, 3, "initial");
        slope_line(plot, QUANTITY_DILATANCY_SLOPE, -1, 1, "dilatancy");
    }
    fputc('\n', plot->out);
}

/* The right axis; of a test at constant volume it has a range, too. */
static void solid_fraction_axis(const struct plot *plot)
{
    fprintf(plot->out, "stats 'curves.csv' using (column('solid_fraction')) nooutput\n"
                       "if (STATS_max - STATS_min < 1e-6) { set y2range [STATS_min - 0.01:STATS_max + 0.01] }\n"
                       "set y2label 'solid fraction'\nset y2tics\n");
}

static void fabric(const struct plot *plot)
{
    abscissa(plot);
    solid_fraction_axis(plot);
    fprintf(plot->out,
            "set ylabel 'contacts per particle'\n"
            "plot 'curves.csv' using (%s):(column('coordination')) with lines linewidth 2 linecolor '" BLUE
            "' title 'coordination', \\\n"
            "     '' using (%s):(column('coordination_no_rattlers')) with lines linewidth 2 dashtype (14,7) linecolor "
            "'" GREEN "' title 'without rattlers', \\\n"
            "     '' using (%s):(column('solid_fraction')) axes x1y2 with lines linewidth 2 linecolor '" ORANGE
            "' title 'solid fraction (right)'\n",
            plot->x, plot->x, plot->x);
}

static void loops(const struct plot *plot)
{
    size_t n = plot->analysis->cycles.n, chosen[3] = {1, 2, n};
    static const char *const colours[] = {BLUE, GREEN, ORANGE};
    const struct stress_unit unit = stress_unit(plot);
    fprintf(plot->out, "s = %g\nset ylabel 'deviatoric stress {/Symbol s}_D [%s]'\n", unit.factor, unit.name);
    fprintf(plot->out,
            "set xlabel 'deviatoric strain {/Symbol e}_D [%%]'\n"

            "plot 'curves.csv' using (100*column('eps_d')):(s*column('sigma_d_pa')) with lines linewidth 0.8 linecolor "
            "'" GREY "' title 'all %zu cycles'",
            n);
    for (size_t k = 0; k < 3; k++)
        if (chosen[k] <= n && chosen[k] > (k ? chosen[k - 1] : 0))
            fprintf(plot->out,
                    ", \\\n     '' using (column('cycle') == %zu ? 100*column('eps_d') : NaN):(s*column('sigma_d_pa')) "
                    "with "
                    "lines linewidth 2 linecolor '%s' title 'cycle %zu'",
                    chosen[k], colours[k], chosen[k]);
    fputc('\n', plot->out);
}

static void accumulation(const struct plot *plot)
{
    fprintf(plot->out,
            "set xlabel 'cycles'\nset ylabel 'accumulated strain [%%]'\n"
            "plot 'cycles.csv' using 1:(100*column('eps_d')) with linespoints pointtype 7 pointsize 0.5 linewidth "
            "1.5 linecolor '" BLUE "' title '{/Symbol e}_D', \\\n"
            "     '' using 1:(100*column('eps_v')) with linespoints pointtype 6 pointsize 0.5 linewidth 1.5 "
            "linecolor '" ORANGE "' title '{/Symbol e}_V (compression positive)'\n");
}

static void accumulation_log(const struct plot *plot)
{
    const struct quantity *q = plot->analysis->quantity;
    double a = q[QUANTITY_CYCLES_ACCUMULATION_FACTOR].value, b = q[QUANTITY_CYCLES_ACCUMULATION_EXPONENT].value;
    fprintf(plot->out,
            "set logscale xy\nset offsets 0, 0, 0, 0\nset autoscale y\nset xrange [0.9:%zu]\nset mxtics 10\nset mytics "
            "10\nset format y '10^{%%T}'\n"
            "set xlabel 'cycles N'\nset ylabel 'accumulated strain |{/Symbol e}_D|'\n"
            "plot 'cycles.csv' using 1:(abs(column('eps_d'))) with points pointtype 7 pointsize 0.7 linecolor '" BLUE
            "' title '|{/Symbol e}_D|'",
            2 * plot->analysis->cycles.n);
    if (isfinite(a) && isfinite(b))
        fprintf(plot->out,
                ", \\\n     %.10g*x**(%.10g) with lines linewidth 2 dashtype (14,7) linecolor '" ORANGE
                "' title 'fit a N^{b}, b = %.3g'",
                a, b, b);
    fputc('\n', plot->out);
}

/* The path in the plane of p and q. */
static void path(const struct plot *plot)
{
    const struct stress_unit unit = stress_unit(plot);
    fprintf(plot->out,
            "s = %g\nset xlabel 'p [%s]'\nset ylabel 'q [%s]'\n"
            "plot 'curves.csv' using (s*column('p_pa')):(s*column('q_pa')) with lines linewidth 2 linecolor '" BLUE
            "' title 'path', \\\n"
            "     '' using (s*column('p_pa')):(s*column('q_pa')) every ::0::0 with points pointtype 7 pointsize 0.9 "
            "linecolor 'black' title 'start'\n",
            unit.factor, unit.name, unit.name);
}

static void stiffness(const struct plot *plot)
{
    fprintf(
        plot->out,
        "set logscale x\nset format x '10^{%%T}'\nset mxtics 10\n"
        "set xlabel 'axial strain |{/Symbol e}_{zz}|'\nset ylabel 'modulus [kPa]'\n"
        "plot 'stiffness.csv' using 'eps_zz':(1e-3*column('secant_pa')) with lines linewidth 2 linecolor '" BLUE
        "' title 'secant q/{/Symbol e}_{zz}', \\\n"
        "     '' using 'eps_zz':(1e-3*column('tangent_pa')) with lines linewidth 2 dashtype (14,7) linecolor '" ORANGE
        "' title 'tangent'\n");
}

static void void_ratio(const struct plot *plot)
{
    const bool isotropic = plot->analysis->curves.controls.kind == TEST_ISOTROPIC;
    const struct stress_unit unit = stress_unit(plot);
    fprintf(plot->out,
            "s = %g\nset logscale x\nset xlabel '%s [%s]'\nset ylabel 'void ratio e'\n"
            "plot 'curves.csv' using (column('%s') > 0 ? s*column('%s') : NaN):(column('void_ratio')) with lines "
            "linewidth 2 linecolor '" BLUE "' notitle\n",
            unit.factor, isotropic ? "p" : "{/Symbol s}_{zz}", unit.name, isotropic ? "p_pa" : "sigma_zz_pa",
            isotropic ? "p_pa" : "sigma_zz_pa");
}

/* All stages of the run over time. */
static void whole_path(const struct plot *plot)
{
    const struct stress_unit unit = stress_unit(plot);
    solid_fraction_axis(plot);
    fprintf(plot->out,
            "s = %g\nset xlabel 'time [s]'\nset ylabel 'stress [%s]'\n"
            "plot 'curves.csv' using (column('time_s')):(s*column('p_pa')) with lines linewidth 2 linecolor '" BLUE
            "' title 'p', \\\n"
            "     '' using (column('time_s')):(s*column('q_pa')) with lines linewidth 2 linecolor '" GREEN
            "' title 'q', \\\n"
            "     '' using (column('time_s')):(column('solid_fraction')) axes x1y2 with lines linewidth 2 linecolor "
            "'" ORANGE "' title 'solid fraction (right)'\n",
            unit.factor, unit.name);
}

static const struct plot_kind {
    const char *stem;
    void (*body)(const struct plot *plot);
    unsigned tests; /* that have the plot */
} kinds[] = {
    {"stress_strain", stress_strain, TESTS_ANY},
    {"volumetric_strain", volumetric_strain, TESTS_ANY},
    {"fabric", fabric, TESTS_ANY},
    {"path", path, TESTS_SHEAR | TESTS_CYCLIC},
    {"stiffness", stiffness, TESTS_SHEAR},
    {"void_ratio", void_ratio, TESTS_COMPRESSION},
    {"loops", loops, TESTS_CYCLIC},
    {"accumulation", accumulation, TESTS_CYCLIC},
    {"accumulation_log", accumulation_log, TESTS_CYCLIC},
};

static const struct plot_kind of_all_stages[] = {
    {"path", path, TESTS_ANY},
    {"whole_path", whole_path, TESTS_ANY},
};

static bool is_made(const struct analysis *analysis, const struct plot_kind *kind)
{
    if (!(kind->tests >> analysis->curves.controls.kind & 1))
        return false;
    return kind->body == stiffness ? analysis->stiffness.n > 1 : kind->tests != TESTS_CYCLIC || analysis->cycles.n > 0;
}

static enum status script_write(const struct analysis *analysis, const struct plot_kind *kind)
{
    char path[sizeof analysis->directory + 64];
    snprintf(path, sizeof path, "%s/%s.gp", analysis->directory, kind->stem);
    struct plot plot = {analysis, fopen(path, "w"), "column('stage_time_s')"};
    char strain[64];
    snprintf(strain, sizeof strain, "100*column('%s')", curve_name(plot_axial(&plot)));
    if (analysis->curves.controls.kind == TEST_SHEAR)
        plot.x = strain;
    if (!plot.out)
        return status_fail(STATUS_IO, "%s: %s", path, strerror(errno));
    fprintf(plot.out, preamble, kind->stem, kind->stem);
    kind->body(&plot);
    fprintf(plot.out, epilogue, kind->stem);
    int failed = ferror(plot.out); /* sticky: covers every write above */
    if (fclose(plot.out) != 0 || failed)
        return status_fail(STATUS_IO, "%s: cannot be written: %s", path, strerror(errno));
    return STATUS_OK;
}

enum status plots_run(const char *directory, const char *stem)
{
    char program[] = "gnuplot", script[64];
    char *const arguments[] = {program, script, NULL};
    posix_spawn_file_actions_t actions;
    pid_t child;
    int how = 0;
    snprintf(script, sizeof script, "%s.gp", stem);
    if (posix_spawn_file_actions_init(&actions) != 0)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    int failed = posix_spawn_file_actions_addchdir_np(&actions, directory);
    if (failed == 0)
        failed = posix_spawnp(&child, program, &actions, NULL, arguments, environ);
    if (posix_spawn_file_actions_destroy(&actions) != 0 && failed == 0)
        failed = EINVAL;
    if (failed != 0)
        return status_fail(STATUS_IO, "gnuplot cannot be run (is gnuplot-nox installed?): %s", strerror(failed));
    while (waitpid(child, &how, 0) < 0)
        if (errno != EINTR)
            return status_fail(STATUS_IO, "gnuplot: %s", strerror(errno));
    if (!WIFEXITED(how) || WEXITSTATUS(how) != 0)
        return status_fail(STATUS_IO, "%s/%s: gnuplot failed", directory, script);
    return STATUS_OK;
}

enum status plots_write(const struct analysis *analysis, int *n_made)
{
    *n_made = 0;
    if (analysis->curves.n < 2)
        return STATUS_OK;
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
        if (!is_made(analysis, &kinds[k]))
            continue;
        TRY(script_write(analysis, &kinds[k]));
        TRY(plots_run(analysis->directory, kinds[k].stem));
        (*n_made)++;
    }
    return STATUS_OK;
}

enum status plots_write_path(const struct analysis *analysis)
{
    for (size_t k = 0; k < sizeof of_all_stages / sizeof of_all_stages[0]; k++) {
        TRY(script_write(analysis, &of_all_stages[k]));
        TRY(plots_run(analysis->directory, of_all_stages[k].stem));
    }
    return STATUS_OK;
}
