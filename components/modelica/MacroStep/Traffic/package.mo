within MacroStep;
package Traffic "Blocks of the traffic socket"
end Traffic;
