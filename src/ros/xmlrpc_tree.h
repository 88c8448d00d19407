#pragma once

#include <xmlrpcpp/XmlRpcValue.h>

#include "mass_spring_sim/tree.h"

namespace mass_spring {

/// What the parameter server holds, as the reader of scenes wants it. Dates and binary data, which
/// no scene knows, become the text that their YAML was.
Tree toTree(const XmlRpc::XmlRpcValue& value);

}  // namespace mass_spring
