# Picture of the table that bench_scaling prints; variables: table, picture.
set terminal pngcairo size 800,500
set output picture
set logscale x
set xlabel "particles"
set ylabel "ns per particle and step"
set yrange [0:*]
set key top left
rows(dimension, threads) = sprintf("< awk '$1 == \"%dD\" && $3 == %d { print $2, $8 }' '%s'", dimension, threads, table)
plot rows(2, 1) with linespoints title "2D, scene A's material, 1 thread", \
     rows(2, 2) with linespoints title "2D, 2 threads", \
     rows(3, 1) with linespoints title "3D with friction, scene B's material, 1 thread", \
     rows(3, 2) with linespoints title "3D, 2 threads"
