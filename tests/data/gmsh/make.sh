#!/bin/sh
# Makes the meshes of this folder; they were made by gmsh 4.8.4 of Debian 12.
# (gmsh writes version 4.0 in text only.)
set -e
cd "$(dirname "$0")"
for case in "pieces -2" "cube -3"; do
    set -- $case
    for version in 22 40 41; do
        gmsh "$1.geo" "$2" -v 2 -format "msh$version" -o "$1-$version.msh"
        gmsh "$1.geo" "$2" -v 2 -format "msh$version" -parametric -o "$1-$version-parametric.msh"
    done
    for version in 22 41; do
        gmsh "$1.geo" "$2" -v 2 -format "msh$version" -bin -o "$1-$version-bin.msh"
        gmsh "$1.geo" "$2" -v 2 -format "msh$version" -bin -parametric -o "$1-$version-bin-parametric.msh"
        gmsh "$1.geo" "$2" -v 2 -format "msh$version" -order 2 -o "$1-$version-order2.msh"
        gmsh "$1.geo" "$2" -v 2 -format "msh$version" -bin -save_all -o "$1-$version-bin-all.msh"
        gmsh "$1.geo" "$2" -v 2 -format "msh$version" -part 2 -o "$1-$version-partitioned.msh"
    done
done
gmsh graded.geo -2 -v 2 -format msh41 -o graded.msh
