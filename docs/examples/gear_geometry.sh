# Geometry and unloaded contact of a gear pair: no load, no friction.
mixed-ehl geometry fm_spiral_bevel_14x39 --side drive --report geometry.html
mixed-ehl geometry fm_spiral_bevel_14x39 --side coast --E "0.05 mm" --shaft-angle-error "1 arcmin" --plot geometry
mixed-ehl export fm_spiral_bevel_14x39 -o files --member pinion --rows 9 --columns 15
mixed-ehl misalignment fm_spiral_bevel_14x39 --E "-0.1, 0, 0.1 mm" --P "-0.1:0.1:3 mm" --csv misalignment.csv --plot misalignment
