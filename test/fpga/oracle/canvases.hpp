#pragma once
// Inputs drawn on purpose, one function a kind.

#include "generator.hpp"

namespace oracle {

void drawOptions(Params& p, Random& random);
void setHomography(Params& p, const Coefficients& h);
void setSize(Params& p, int width, int height);

Inputs canvas(Random& random, int width, int height);
Inputs drawnTriangles(Random& random, int width, int height);
Inputs drawnComb(Random& random);
Inputs drawnPlateaus(Random& random);
Inputs drawnTallBands(Random& random);
Inputs drawnTies(Random& random);
Inputs extremeFocus(Random& random);
Inputs focusInside(Random& random);
Inputs fewLevels(Random& random);
Inputs saturating(Random& random);
Inputs limits(Random& random);
Inputs anything(Random& random, bool extremes);
Inputs tiny(Random& random);
Inputs memoryOverlap(Random& random);

}  // namespace oracle
