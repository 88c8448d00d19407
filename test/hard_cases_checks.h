#pragma once

#include "hard_cases_watch.h"

// What the rows of the table run, by the number of the row. Each builds its scene, steps it and
// checks the criterion.
namespace mass_spring {

// Starts that plain code does not survive.
void coincidentEnds(Trial& trial);          // 1
void restLengthZero(Trial& trial);          // 2
void allAtOnePoint(Trial& trial);           // 3
void compressedToOnePercent(Trial& trial);  // 4
void flatSheetCompressed(Trial& trial);     // 5
void scrambledStart(Trial& trial);          // 6
void flattenedStart(Trial& trial);          // 7
void longStep(Trial& trial);                // 10
void spinningRing(Trial& trial);            // 21

// Systems of equations that plain solvers do not solve.
void stiffnessRatioInChain(Trial& trial);     // 8
void stiffnessRatioInSheet(Trial& trial);     // 8
void loadOnLightRope(Trial& trial);           // 9
void allPinned(Trial& trial);                 // 14
void isolatedParticle(Trial& trial);          // 15
void springBothWays(Trial& trial);            // 16
void thousandComponents(Trial& trial);        // 17
void stiffnessZero(Trial& trial);             // 19
void longRope(Trial& trial);                  // 20
void warmStart(Trial& trial);                 // 24
void cappedConjugateGradients(Trial& trial);  // 25
void zeroRightSide(Trial& trial);             // 26

// Bad input, and what is done to a scene from outside.
void billionNewtons(Trial& trial);       // 11
void pinTeleported(Trial& trial);        // 12
void rotatedScene(Trial& trial);         // 13
void badValuesRefused(Trial& trial);     // 18
void otherUnits(Trial& trial);           // 28
void gripperSqueezesShut(Trial& trial);  // 30

// Long runs.
void millionSteps(Trial& trial);          // 22
void longRest(Trial& trial);              // 23
void stiffSheetInFreeFall(Trial& trial);  // 27
void heldAtOneCorner(Trial& trial);       // 29

}  // namespace mass_spring
