#include "scene/timeline_reader.h"

#include <algorithm>

#include "scene/command_reader.h"

namespace mass_spring {
namespace {

struct Entry {
  TimedCommand timed;
  Place pin;  ///< of the command, if it is one
};

void readEntry(const Place& place, const ParticleCounts& counts, const Limits& limits,
               const std::vector<std::string>* shapes, std::vector<Entry>& entries) {
  MapReader keys(place, "a map with time and one of force, pin, shape and clear");
  TimedCommand timed;
  keys.required("time").read(timed.time, atLeastZero("s"));
  const Place force = keys.optional("force");
  const Place pin = keys.optional("pin");
  const Place shape = keys.optional("shape");
  const Place clear = keys.optional("clear");
  const int commands = force.present() + pin.present() + shape.present() + clear.present();
  if (commands != 1) {
    place.report(commands == 0 ? "no command" : "several commands",
                 "just one of force, pin, shape and clear");
  } else if (force.present()) {
    readForceCommand(force, counts, limits, timed.command.emplace<ForceCommand>());
  } else if (pin.present()) {
    readPinCommand(pin, counts, timed.command.emplace<PinCommand>());
  } else if (shape.present()) {
    readShapeCommand(shape, shapes, timed.command.emplace<ShapeCommand>());
  } else {
    readClearCommand(clear, timed.command.emplace<ClearCommand>());
  }
  keys.refuseUnknown();
  entries.push_back({timed, pin});
}

/// Walks through the timeline as a simulation would, with the pins alone.
void checkPins(const std::vector<Entry>& entries, PinLedger& ledger) {
  for (const Entry& entry : entries) {
    const auto* clear = std::get_if<ClearCommand>(&entry.timed.command);
    if (clear != nullptr && clear->what == ClearCommand::What::kPins) ledger = PinLedger();
    const auto* command = std::get_if<PinCommand>(&entry.timed.command);
    if (command == nullptr) continue;
    const Place name = entry.pin.child("name", true);
    const bool exists = ledger.names().count(command->name) > 0;
    if (command->action == PinCommand::Action::kAdd) {
      if (exists) name.refuse("a name that no pin has at that time");
      ledger.add(command->name, command->object, command->particles,
                 entry.pin.child("particles", false));
    } else if (!exists) {
      const std::vector<std::string> known(ledger.names().begin(), ledger.names().end());
      name.refuse("a pin that exists at that time (" +
                  (known.empty() ? "there is none" : listWords(known)) + ")");
    } else if (command->action == PinCommand::Action::kRemove) {
      ledger.remove(command->name);
    }
  }
}

}  // namespace

std::vector<ScenePin> readPins(const Place& place, const ParticleCounts& counts,
                               PinLedger& ledger) {
  std::vector<ScenePin> pins;
  const Tree::Map* map = place.map("a map of pins");
  if (map == nullptr) return pins;
  for (const auto& [name, tree] : *map) {
    const Place entry = place.child(name, true);
    if (!isName(name)) entry.report("the name " + quote(name), kNameRule);
    ScenePin pin;
    pin.name = name;
    MapReader keys(entry, "a map with object and particles");
    readFrame(keys.optional("follow_frame"), pin.follow_frame);
    const bool has_object = readObjectName(keys.required("object"), counts, pin.object);
    const Place particles = keys.required("particles");
    const auto count = has_object ? counts.at(pin.object) : std::nullopt;
    if (readParticles(particles, count, pin.particles)) {
      if (pin.particles.empty()) particles.refuse("at least one particle index");
      ledger.add(pin.name, pin.object, pin.particles, particles);
    }
    keys.refuseUnknown();
    pins.push_back(std::move(pin));
  }
  return pins;
}

std::vector<TimedCommand> readTimeline(const Place& place, const ParticleCounts& counts,
                                       const Limits& limits, std::optional<PinLedger> ledger,
                                       const std::vector<std::string>* shapes) {
  std::vector<TimedCommand> timeline;
  if (!place.present()) return timeline;
  const Tree::List* list = place.list("a list of commands");
  if (list == nullptr) return timeline;
  const std::size_t problems_before = place.problems().count();
  std::vector<Entry> entries;
  for (std::size_t i = 0; i < list->size(); ++i) {
    readEntry(place.element(i), counts, limits, shapes, entries);
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.timed.time < b.timed.time; });
  if (ledger && place.problems().count() == problems_before) checkPins(entries, *ledger);
  for (Entry& entry : entries) timeline.push_back(std::move(entry.timed));
  return timeline;
}

}  // namespace mass_spring
