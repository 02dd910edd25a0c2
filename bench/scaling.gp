# Picture of the table that bench_scaling prints; variables: table, picture.
set terminal pngcairo size 800,560
set output picture
set logscale x
set xlabel "particles"
set ylabel "ns per particle and step"
set key outside bottom center maxcols 3
rows(dimension, precision, threads, column) = sprintf( \
    "< awk '$1 == \"%dD\" && $3 == %d && $4 == \"%s\" { print $2, $%d }' '%s'", dimension, threads, precision, column, table)
set logscale y
set grid
last = system(sprintf("awk '$3 == 2' '%s' | wc -l", table)) > 0 ? 3 : 1 # of two threads, if there are any
set yrange [*:*]
plot for [d = 2:3] for [p in "double mixed"] rows(d, p, 1, 9) with linespoints title sprintf("%dD, %s", d, p), \
     for [d = 2:last] for [p in "double mixed"] rows(d, p, 2, 9) with linespoints dashtype 2 title sprintf("%dD, %s, 2 threads", d, p), \
     for [d = 2:3] rows(d, "double", 1, 11) with lines dashtype 3 linecolor "gray40" linewidth 2 title sprintf("%dD, double: its bytes in order", d)
